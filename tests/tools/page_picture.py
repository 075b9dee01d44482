"""A picture of a page in a headless Chromium, for the docs: page_picture.py PAGE OUT.webp WIDTH HEIGHT [JAVASCRIPT [CONDITION]].

Runs JAVASCRIPT once the page is there, and waits until CONDITION holds."""

import base64
import pathlib
import sys
import tempfile
import time

from browser import Browser, find_chromium

page, out, width, height = sys.argv[1], sys.argv[2], int(sys.argv[3]), int(sys.argv[4])
script, condition = (sys.argv[5:] + ["", ""])[:2]
with tempfile.TemporaryDirectory(ignore_cleanup_errors=True) as profile:
    browser = Browser(find_chromium(), profile)
    try:
        browser.open(pathlib.Path(page).resolve().as_uri(), width, height)
        browser.wait("document.readyState === 'complete'")
        if script:
            browser.evaluate(script)
        if condition:
            browser.wait(condition)
        time.sleep(1)
        picture = browser.call("Page.captureScreenshot", format="webp", quality=82)["data"]
    finally:
        browser.close()
with open(out, "wb") as file:
    file.write(base64.b64decode(picture))
