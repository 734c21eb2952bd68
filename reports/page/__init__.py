"""`report.html`: the whole report on one page, in a single file that needs no network."""
