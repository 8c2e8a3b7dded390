"""What reports are made of: pages, drawings, colours, numbers in words.

A report of its own for a results folder comes in by the hook ``tacos_report``. Importing this package loads
neither matplotlib nor jinja2.
"""
