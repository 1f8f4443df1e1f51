#!/bin/sh
# report_browser.sh OUT PAGE...: pages of `report` in headless Chromium (needs chromium and python3).
# Prints, for each page: console messages, requests, horizontal scroll at 360 px, layout shift, least contrast
# of text in both themes, and what dragging, the keys and the buttons do to the drawing of lights. Leaves in
# OUT, to be looked at: PAGE-desktop.png, PAGE-dark.png, PAGE-phone.png, PAGE-phone-dark.png,
# PAGE-print.png and PAGE.pdf.
exec python3 "$(dirname "$0")/report_browser.py" "$@"
