"""Whole studies: what is run, what is checked, what the report says.

analysis, results, plot, report -> [studies] -> report.html, figures, data, summary.json
"""
