"""Reports: one self-contained HTML file each, made from numbers and figures.

sections of text, tables, figures, checks -> [report] -> report.html
"""

from rollerrig.report.page import Check, Figure, Page, Preformatted, Section, Table, Text, check_table, number, render

__all__ = ["Check", "Figure", "Page", "Preformatted", "Section", "Table", "Text", "check_table", "number", "render"]
