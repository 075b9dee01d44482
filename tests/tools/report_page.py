"""Pages of pm-report in a headless Chromium: report_page.py KIND PAGE [SCREENSHOTS_DIR], KIND accepted, refused, unfinished or index."""

import json
import os
import pathlib
import sys
import tempfile
import time

from browser import Browser, find_chromium

KIND, PAGE = sys.argv[1], os.path.abspath(sys.argv[2])
SHOTS = sys.argv[3] if len(sys.argv) > 3 else None
VERDICT = {"accepted": "accepted", "refused": "nothing accepted", "unfinished": "not finished", "index": ""}[KIND]


def check(browser, width, height, dark):
    browser.open(pathlib.Path(PAGE).as_uri(), width, height, touch=width < 500, dark=dark)
    assert browser.evaluate("document.documentElement.scrollWidth") <= width, "the page is wider than the window"
    assert browser.evaluate("document.querySelectorAll('h1').length") == 1
    assert browser.evaluate("document.documentElement.lang") == "en"
    # Whoever cannot see is told: pictures, videos, controls and plots have names, sections headings.
    unnamed = browser.evaluate("""[...document.querySelectorAll('img, video, button, select, input, svg[role=img]')].filter(e =>
        e.tagName === 'IMG' ? !e.hasAttribute('alt') : !(e.textContent.trim() || e.getAttribute('aria-label'))).map(e => e.outerHTML.slice(0, 80))""")
    assert unnamed == [], unnamed
    if KIND != "index":
        assert browser.evaluate("document.querySelector('header .chip').textContent") == VERDICT
        assert browser.evaluate("[...document.querySelectorAll('main > section')].slice(1).every(s => s.querySelector('h2'))")
        # Where navigation leads is there.
        gone = browser.evaluate("[...document.querySelectorAll('nav a')].map(a => a.getAttribute('href')).filter(h => !document.querySelector(h))")
        assert gone == [], gone
    # Every number links to its file, which lies beside the page.
    links = browser.evaluate("[...new Set([...document.querySelectorAll('main a')].map(a => a.getAttribute('href')))].filter(h => !h.startsWith('#'))")
    for link in links:
        assert os.path.exists(os.path.join(os.path.dirname(PAGE), link)), link
    if browser.evaluate("!!document.querySelector('#viewer')"):
        browser.evaluate("document.querySelector('#viewer').scrollIntoView()")
        browser.wait("viewer && viewer.state.loaded > 0 && viewer.settled()")
    if KIND == "accepted":
        assert browser.evaluate("!!document.querySelector('#viewer canvas')")
        browser.wait("[...document.querySelectorAll('video')].every(v => v.readyState >= 1 && v.videoWidth > 0)")
        browser.click("#play-all")
        browser.wait("[...document.querySelectorAll('.card video')].every(v => v.currentTime > 0 || v.ended)")
        browser.click("#play-all")
        browser.click(".stills button:last-child")
    assert browser.evaluate("document.body.textContent.includes('<script>') === document.documentElement.outerHTML.includes('&lt;script&gt;')")
    others = [a for a in browser.requested() if not a.startswith((pathlib.Path(PAGE).as_uri(), "blob:", "data:"))]
    assert others == [], others
    assert browser.complaints() == [], browser.complaints()
    if SHOTS:
        browser.evaluate("scrollTo(0, 0)")
        time.sleep(0.5)
        browser.screenshot(os.path.join(SHOTS, f"report-{KIND}-{width}-{'dark' if dark else 'light'}.png"))


def main():
    with tempfile.TemporaryDirectory(ignore_cleanup_errors=True) as profile:
        browser = Browser(find_chromium(), profile)
        try:
            for width, height, dark in ((1280, 800, False), (390, 844, True)):
                check(browser, width, height, dark)
        finally:
            browser.close()
    print(json.dumps({"bytes": os.path.getsize(PAGE)}))


main()
