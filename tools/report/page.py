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
body { max-width: 54rem; margin: 2rem auto; padding: 0 1rem; color: #222; font: 16px/1.5 Georgia, "DejaVu Serif", serif; }
h1, h2, h3 { font-family: "Helvetica Neue", Arial, "DejaVu Sans", sans-serif; line-height: 1.25; }
h2 { border-bottom: 1px solid #ccc; margin-top: 2.2em; padding-bottom: .2em; }
.wide, .formula { overflow-x: auto; margin: .6em 0 1.2em; }
.formula { text-align: center; }
table { border-collapse: collapse; font-size: .8rem; }
th, td { border: 1px solid #ccc; padding: .25em .55em; vertical-align: top; text-align: left; }
th, pre { background: #f4f4f4; }
img { max-width: 100%; }
@page { size: A4; margin: 14mm; }
@media print {
  body { max-width: none; margin: 0; padding: 0; font-size: 9.1pt; line-height: 1.3; }
  h1, h2, h3, .caption { break-after: avoid; }
  tr, img, pre, math, .wide, .caption { break-inside: avoid; }
  table { font-size: 6.6pt; line-height: 1.2; }
  img { max-width: 78%; max-height: 82mm; }
}
"""
FORMULA = r"\$\$(.+?)\$\$|(?<![\\\w$])\$([^$\n`]+(?:\n[^$\n`]+)?)\$"


def formulas(text):
    """The text with a mark in place of each formula, $$...$$ or $...$, outside of code; and their MathML."""
    made = []

    def one(match):
        made.append(convert(" ".join((match[1] or match[2]).split()), display="block" if match[1] else "inline"))
        return f"FORMULA{len(made) - 1}MADE"

    parts = re.split(r"(^ {4}.*$|`[^`\n]*`)", text, flags=re.M)
    whole = "".join(part if k % 2 else part.replace("$", "\0") for k, part in enumerate(parts))
    return re.sub(FORMULA.replace("$", "\0").replace("\\\0", "\0"), one, whole, flags=re.S).replace("\0", "$"), made


def embed(folder):
    """A function that puts, for each src="...", the file's content in place of its name."""

    def image(match):
        with open(os.path.join(folder, html.unescape(match[1])), "rb") as f:
            return f'src="data:image/png;base64,{base64.b64encode(f.read()).decode()}"'

    return image


def make(text, folder, name):
    """Writes NAME.html and NAME.pdf."""
    page, path = (os.path.abspath(os.path.join(folder, f"{name}.{end}")) for end in ("html", "pdf"))
    text, mathml = formulas(marks.without(text))
    body = markdown.markdown(text, extensions=["tables", "toc", "sane_lists", "attr_list"])
    body = re.sub(r"<p>FORMULA(\d+)MADE</p>", lambda m: f'<div class="formula">{mathml[int(m[1])]}</div>', body)
    body = re.sub(r"FORMULA(\d+)MADE", lambda m: mathml[int(m[1])], body)
    body = re.sub(r"(?<=\d) (?=\d{3}\b)", "&nbsp;", body)  # thousands
    body = re.sub(r"<p>(<strong>(?:Table|Figure) \d+\.</strong>)", r'<p class="caption">\1', body)
    body = re.sub(r"(<table>.*?</table>)", r'<div class="wide">\1</div>', body, flags=re.S)
    body = re.sub(r'src="([^"]*)"', embed(folder), re.sub(r"<!--.*?-->\n?", "", body, flags=re.S))
    title = html.escape(re.search(r"^# (.*)", text, re.M)[1])
    head = f'<meta charset="utf-8">\n<meta name="viewport" content="width=device-width">\n<title>{title}</title>\n<style>{STYLE}</style>'
    with open(page, "w") as f:
        f.write(f'<!DOCTYPE html>\n<html lang="en">\n<head>\n{head}\n</head>\n<body>\n{body}\n</body>\n</html>\n')
    print(f"  {os.path.relpath(page)}")
    browser = next((b for b in ("chromium", "chromium-browser", "google-chrome") if shutil.which(b)), None)
    if not browser:
        return print(f"  no {name}.pdf: it is printed by Chromium, which is not installed (Debian: apt-get install chromium)")
    with tempfile.TemporaryDirectory() as home:
        command = [browser, "--headless", "--no-sandbox", "--disable-gpu", f"--user-data-dir={home}", "--no-pdf-header-footer"]
        done = subprocess.run([*command, f"--print-to-pdf={path}", f"file://{page}"], capture_output=True, text=True)
    print(f"  no {name}.pdf: {browser} failed: {done.stderr.strip()[-200:]}" if done.returncode else f"  {os.path.relpath(path)}")
