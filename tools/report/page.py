"""Writes a Markdown document as one HTML file that needs nothing else: figures are embedded, formulas stay plain text."""

import base64
import html
import os
import re

import markdown
import marks

STYLE = """
body { max-width: 54rem; margin: 2rem auto; padding: 0 1rem; font: 16px/1.5 Georgia, "DejaVu Serif", serif; color: #222; }
h1, h2, h3 { font-family: "Helvetica Neue", Arial, "DejaVu Sans", sans-serif; line-height: 1.25; }
h2 { border-bottom: 1px solid #ccc; margin-top: 2.2em; padding-bottom: .2em; }
figure { margin: 1em 0; }
figcaption { font-size: .85rem; color: #555; }
nav { font-size: .9rem; }
table { border-collapse: collapse; font-size: .85rem; margin: 1em 0; display: block; overflow-x: auto; }
th, td { border: 1px solid #ccc; padding: .25em .55em; vertical-align: top; text-align: left; }
th { background: #f2f2f2; }
pre { background: #f6f6f6; border: 1px solid #e2e2e2; padding: .6em .8em; overflow-x: auto; font-size: .85rem; line-height: 1.4; }
code { font-family: "DejaVu Sans Mono", Menlo, Consolas, monospace; font-size: .92em; }
img { max-width: 100%; }
@media print { body { max-width: none; font-size: 11pt; } h2 { break-after: avoid; } table, img, pre { break-inside: avoid; } }
"""


def embed(folder):
    """A function that puts, for each <img ...>, the file's content in place of its name."""

    def image(match):
        name = html.unescape(re.search(r'src="([^"]*)"', match[0])[1])
        path = os.path.join(folder, name)
        if not os.path.isfile(path):
            return f"<em>(The figure {html.escape(name)} is missing: no data.)</em>"
        with open(path, "rb") as f:
            return match[0].replace(
                f'src="{html.escape(name)}"', f'src="data:image/png;base64,{base64.b64encode(f.read()).decode()}"'
            )

    return image


def write(text, folder, path):
    title = re.search(r"^# (.*)", text, re.M)[1]
    extensions = ["tables", "toc", "sane_lists", "attr_list"]
    made = markdown.Markdown(extensions=extensions, extension_configs={"toc": {"toc_depth": "2-2"}}, output_format="html")
    body = made.convert(marks.without(text))
    body = body.replace("</h1>", f"</h1>\n<nav>{made.toc}</nav>", 1)
    body = re.sub(r"<!--.*?-->\n?", "", body, flags=re.S)
    body = re.sub(r'<p>(<img alt="([^"]*)"[^>]*>)</p>', r"<figure>\1<figcaption>\2</figcaption></figure>", body)
    body = re.sub(r"<img [^>]*>", embed(folder), body)
    with open(path, "w") as f:
        f.write(
            f'<!DOCTYPE html>\n<html lang="en">\n<head>\n<meta charset="utf-8">\n<meta name="viewport" content="width=device-width">\n'
            f"<title>{html.escape(title)}</title>\n<style>{STYLE}</style>\n</head>\n<body>\n{body}\n</body>\n</html>\n"
        )
    print(f"  {os.path.relpath(path)}")
