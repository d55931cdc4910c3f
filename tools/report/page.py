"""Writes a Markdown document as one HTML file that needs nothing else: figures are embedded, formulas are MathML.
Chromium, where it is installed, prints that file as PDF."""

import base64
import html
import os
import re
import shutil
import subprocess
import tempfile

import markdown
import marks
from latex2mathml.converter import convert

STYLE = """
body { max-width: 54rem; margin: 2rem auto; padding: 0 1rem; color: #222; }
body { font: 16px/1.5 Georgia, "DejaVu Serif", serif; }
h1, h2, h3 { font-family: "Helvetica Neue", Arial, "DejaVu Sans", sans-serif; line-height: 1.25; }
h2 { border-bottom: 1px solid #ccc; margin-top: 2.2em; padding-bottom: .2em; }
figure { margin: 1em 0; }
figcaption { font-size: .85rem; color: #555; }
nav { font-size: .9rem; }
.wide { overflow-x: auto; margin: .4em 0 1.4em; }
table { border-collapse: collapse; font-size: .8rem; }
math { font-size: 1.02em; }
.formula { margin: .8em 0; overflow-x: auto; overflow-y: hidden; text-align: center; }
math { font-family: "STIX Two Math", "Cambria Math", "Latin Modern Math", math; }
td:first-child { white-space: nowrap; }
.caption { font-size: .92rem; }
th, td { border: 1px solid #ccc; padding: .25em .55em; vertical-align: top; text-align: left; }
th { background: #f2f2f2; }
pre { background: #f6f6f6; border: 1px solid #e2e2e2; padding: .6em .8em; overflow-x: auto; }
pre { font-size: .85rem; line-height: 1.4; }
code { font-family: "DejaVu Sans Mono", Menlo, Consolas, monospace; font-size: .92em; }
img { max-width: 100%; }
@page { size: A4; margin: 16mm 15mm; }
@media print {
  body { max-width: none; margin: 0; padding: 0; font-size: 9.3pt; line-height: 1.32; }
  nav { display: none; }
  h1, h2, h3, .caption { break-after: avoid; }
  h2 { margin-top: 1.2em; }
  .wide, .formula { overflow: visible; break-inside: avoid; }
  pre { overflow: visible; font-size: 7.6pt; }
  .caption { font-size: 8.6pt; }
  table { font-size: 6.9pt; line-height: 1.2; }
  th, td { padding: .12em .35em; }
  tr, img, pre, math { break-inside: avoid; }
  figure { margin: .5em 0; text-align: center; break-after: avoid; }
  .caption { break-inside: avoid; }
  img { max-width: 80%; max-height: 92mm; }
  a { color: inherit; text-decoration: none; }
}
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


FORMULA = r"\$\$(.+?)\$\$|(?<![\\\w$])\$([^$\n`]+(?:\n[^$\n`]+)?)\$"


def formulas(text):
    """The text with a mark in place of each formula, $$...$$ or $...$, outside of code; and their MathML."""
    made = []

    def one(match):
        block = match[1] is not None
        made.append(convert(" ".join((match[1] or match[2]).split()), display="block" if block else "inline"))
        return f"FORMULA{len(made) - 1}MADE"

    parts = re.split(r"(^ {4}.*$|`[^`\n]*`)", text, flags=re.M)
    whole = "".join(part if k % 2 else part.replace("$", "\0") for k, part in enumerate(parts))
    whole = re.sub(FORMULA.replace("$", "\0").replace("\\\0", "\0"), one, whole, flags=re.S)
    return whole.replace("\0", "$"), made


def write(text, folder, path):
    title = re.search(r"^# (.*)", text, re.M)[1]
    extensions = ["tables", "toc", "sane_lists", "attr_list"]
    made = markdown.Markdown(
        extensions=extensions, extension_configs={"toc": {"toc_depth": "2-2"}}, output_format="html"
    )
    text, mathml = formulas(marks.without(text))
    body = made.convert(text)
    body = re.sub(r"<p>FORMULA(\d+)MADE</p>", lambda m: f'<div class="formula">{mathml[int(m[1])]}</div>', body)
    body = re.sub(r"FORMULA(\d+)MADE", lambda m: mathml[int(m[1])], body)
    body = re.sub(r"(?<=\d) (?=\d{3}\b)", "&nbsp;", body)  # thousands
    body = re.sub(r"\b([23])-D\b", "\\1&#8209;D", body)
    body = body.replace("</h1>", f"</h1>\n<nav>{made.toc}</nav>", 1)
    body = re.sub(r"<!--.*?-->\n?", "", body, flags=re.S)
    body = re.sub(r'<p>(<img alt="[^"]*"[^>]*>)</p>', r"<figure>\1</figure>", body)
    body = re.sub(r"<p>(<strong>(?:Table|Figure) \d+\.</strong>)", r'<p class="caption">\1', body)
    body = re.sub(r"(<table>.*?</table>)", r'<div class="wide">\1</div>', body, flags=re.S)
    body = re.sub(r"<img [^>]*>", embed(folder), body)
    with open(path, "w") as f:
        f.write(
            '<!DOCTYPE html>\n<html lang="en">\n<head>\n<meta charset="utf-8">\n<meta name="viewport"'
            ' content="width=device-width">\n'
            f"<title>{html.escape(title)}</title>\n<style>{STYLE}</style>\n</head>\n<body>\n{body}\n</body>\n</html>\n"
        )
    print(f"  {os.path.relpath(path)}")


def print_pdf(page, path):
    """Prints the page as PDF, where Chromium is installed."""
    browser = next((b for b in ("chromium", "chromium-browser", "google-chrome") if shutil.which(b)), None)
    if not browser:
        print("  no report.pdf: it is printed by Chromium, which is not installed (Debian: apt-get install chromium)")
        return
    with tempfile.TemporaryDirectory() as home:
        command = [
            browser,
            "--headless",
            "--no-sandbox",
            "--disable-gpu",
            f"--user-data-dir={home}",
            "--no-pdf-header-footer",
        ]
        done = subprocess.run(
            [*command, f"--print-to-pdf={path}", f"file://{os.path.abspath(page)}"], capture_output=True, text=True
        )
    print(
        f"  {os.path.relpath(path)}"
        if not done.returncode
        else f"  no report.pdf: {browser} failed: {done.stderr.strip()[-200:]}"
    )
