"""Writes a Markdown document as HTML, beside its figures; formulas are MathML. A browser prints it."""

import html
import re

import markdown
import marks
from latex2mathml.converter import convert

STYLE = """
body { max-width: 54rem; margin: 2rem auto; padding: 0 1rem; color: #222; font: 16px/1.5 Georgia, "DejaVu Serif", serif; }
.wide { overflow-x: auto; }
table { border-collapse: collapse; font-size: .8rem; }
th, td { border: 1px solid #ccc; padding: .25em .55em; vertical-align: top; text-align: left; }
th, pre { background: #f4f4f4; }
img { max-width: 100%; }
@media print {
  body { max-width: none; font-size: 9pt; line-height: 1.3; }
  table { font-size: 6.6pt; }
  tr, img, pre, math { break-inside: avoid; }
}
"""
# Code, which is left as it is, or a formula.
FORMULA = re.compile(r"^ {4}[^\n]*$|`[^`\n]*`|\$\$(?P<block>.+?)\$\$|(?<![\\\w$])\$(?P<inline>[^$\n`]+(?:\n[^$\n`]+)?)\$", re.M | re.S)


def make(text, path):
    """Writes the page of a document."""
    formulas = []

    def keep(match):
        if not match["block"] and not match["inline"]:
            return match[0]
        formulas.append(convert(" ".join((match["block"] or match["inline"]).split()), display="block" if match["block"] else "inline"))
        return f"FORMULA{len(formulas) - 1}MADE"

    text = FORMULA.sub(keep, marks.without(text))
    body = markdown.markdown(text, extensions=["tables", "toc", "sane_lists", "attr_list"])
    body = re.sub(r"FORMULA(\d+)MADE", lambda m: formulas[int(m[1])], body)
    body = re.sub(r"(?<=\d) (?=\d{3}\b)", "&nbsp;", body)  # thousands
    body = re.sub(r"(<table>.*?</table>)", r'<div class="wide">\1</div>', body, flags=re.S)
    title = html.escape(re.search(r"^# (.*)", text, re.M)[1])
    with open(path, "w") as f:
        f.write(f'<!DOCTYPE html>\n<html lang="en">\n<meta charset="utf-8">\n<title>{title}</title>\n<style>{STYLE}</style>\n{body}\n</html>\n')
