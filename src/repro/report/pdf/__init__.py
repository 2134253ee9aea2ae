"""The report as a paper: typeset from the same content as the page."""
