"""The page of make preview in a headless Chromium.

    preview_page.py PAGE FOLDER    marks a part in every view by clicks and by a stroke, states a material and changes an action; FOLDER
                                   gets marked-inventory.json, marked-materials.json and marked-plan.json as the page saves them
    preview_page.py URL            of pm-report serve: saves there"""

import json
import os
import pathlib
import sys
import tempfile
import time

from browser import PATIENCE, Browser, find_chromium

PAGE, FOLDER = [os.path.abspath(a) for a in sys.argv[1:3]] if len(sys.argv) > 2 else (None, None)
# In fractions of a view: the outline that is clicked, and drawn.
OUTLINE = [(0.2, 0.05), (0.8, 0.05), (0.8, 0.45), (0.2, 0.45)]


def mouse(browser, kind, x, y):
    browser.call("Input.dispatchMouseEvent", type=kind, x=x, y=y, button="left", buttons=0 if kind == "mouseReleased" else 1, clickCount=1)


def mark(browser, view, stroke):
    selector = f".view[data-view={json.dumps(view)}] .over"
    box = browser.evaluate(f"(() => {{ const e = document.querySelector({json.dumps(selector)}); e.scrollIntoView({{block: 'center'}});"
                           " const r = e.getBoundingClientRect(); return [r.x, r.y, r.width, r.height]; })()")
    points = [(box[0] + u * box[2], box[1] + v * box[3]) for u, v in OUTLINE]
    if stroke:
        mouse(browser, "mousePressed", *points[0])
        for (x, y), (u, v) in zip(points, points[1:] + points[:1]):
            for k in range(1, 6):
                mouse(browser, "mouseMoved", x + (u - x) * k / 5, y + (v - y) * k / 5)
        mouse(browser, "mouseReleased", *points[0])
    else:
        for x, y in points:
            mouse(browser, "mousePressed", x, y)
            mouse(browser, "mouseReleased", x, y)
        # One too many, and taken away.
        mouse(browser, "mousePressed", box[0] + 2, box[1] + 2)
        mouse(browser, "mouseReleased", box[0] + 2, box[1] + 2)
        browser.key("Backspace")
        browser.key("Enter", "\r")


def fill(browser, label, value):
    browser.evaluate(f"((e, v) => {{ e.value = v; e.dispatchEvent(new Event('change')); }})([...document.querySelectorAll('[aria-label]')]"
                     f".find(e => e.getAttribute('aria-label') === {json.dumps(label)}), {json.dumps(value)})")


def state_material(browser):
    """Numbers of the first part, as typed; what cannot be is not saved."""
    name = browser.evaluate("parts[0].name")
    said = "document.querySelector('#material-editor [role=status]').textContent"
    browser.click("#save-materials")
    assert browser.evaluate(said) == "Nothing is stated yet.", browser.evaluate(said)
    for wrong in ("0.5", "nan", "<b>", "1e999"):
        fill(browser, "ν of " + name, wrong)
        browser.click("#save-materials")
        assert browser.evaluate(said).startswith("Not saved: ν of "), (wrong, browser.evaluate(said))
    fill(browser, "ν of " + name, "0.31")
    fill(browser, "E of " + name, "4.5e4")
    fill(browser, "ρ of " + name, "321")
    fill(browser, "Material label of " + name, "Foam")
    browser.click("#save-materials")


def change_action(browser):
    """The first action goes the other way, with another strength."""
    browser.evaluate("document.querySelector('.edit').open = true")
    fill(browser, "Strength of action 1", "1e9")
    browser.click("#save-plan")
    assert browser.evaluate("document.querySelector('#action-editor [role=status]').textContent").startswith("Not saved: Strength of action 1")
    fill(browser, "Strength of action 1", "0.21")
    for axis, value in (("x", "3"), ("y", "0"), ("z", "4")):
        fill(browser, f"Direction {axis} of action 1", value)
    browser.click("#save-plan")


def file_of(name):
    path = os.path.join(FOLDER, name)
    end = time.monotonic() + PATIENCE
    while not os.path.exists(path) and time.monotonic() < end:
        time.sleep(0.05)
    return json.load(open(path))


def save_to_server(url):
    with tempfile.TemporaryDirectory(ignore_cleanup_errors=True) as profile:
        browser = Browser(find_chromium(), profile)
        try:
            browser.open(url, 1280, 800)
            browser.click("#save")
            browser.wait("document.querySelector('#editor [role=status]').textContent.startsWith('Saved as ')")
            state_material(browser)
            browser.wait("document.querySelector('#material-editor [role=status]').textContent.includes('AUTHORED=')")
            change_action(browser)
            browser.wait("document.querySelector('#action-editor [role=status]').textContent.includes('PLAN=')")
            assert all(a.startswith((url, "data:")) for a in browser.requested()), browser.requested()
            assert browser.complaints() == [], browser.complaints()
        finally:
            browser.close()


def main():
    os.makedirs(FOLDER, exist_ok=True)
    shots = os.environ.get("SCREENSHOTS")
    with tempfile.TemporaryDirectory(ignore_cleanup_errors=True) as profile:
        browser = Browser(find_chromium(), profile)
        try:
            for width, height, dark in ((390, 844, True), (1280, 800, False)):
                browser.open(pathlib.Path(PAGE).as_uri(), width, height, touch=width < 500, dark=dark)
                assert browser.evaluate("document.documentElement.scrollWidth") <= width
                if shots:
                    browser.screenshot(os.path.join(shots, f"preview-{width}-{'dark' if dark else 'light'}.png"))
            browser.call("Browser.setDownloadBehavior", behavior="allow", downloadPath=FOLDER)
            assert browser.evaluate("[...document.querySelectorAll('img, button, input, select')].every(e => e.alt || e.textContent.trim() || e.getAttribute('aria-label'))")
            browser.click(".switch [data-show=labels]")
            assert browser.evaluate("getComputedStyle(document.querySelector('.labels')).opacity") == "1"
            before = browser.evaluate("parts.length")
            browser.evaluate("document.querySelector('#editor .row button').click()")
            browser.call("Input.insertText", text="the <b>head</b>")
            browser.evaluate("document.activeElement.blur()")
            browser.evaluate("(s => { s.value = 'Rubber'; s.dispatchEvent(new Event('change')); })(document.querySelector('#editor .part:last-child select'))")
            views = browser.evaluate("views.map(v => v.dataset.view)")
            for k, view in enumerate(views):
                mark(browser, view, stroke=k % 2 == 1)
            assert browser.evaluate("parts.length") == before + 1
            assert browser.evaluate("Object.values(parts.at(-1).marks).map(m => m.length)") == [1] * len(views), browser.evaluate("JSON.stringify(parts.at(-1).marks)")
            if shots:
                browser.screenshot(os.path.join(shots, "preview-marked.png"))
            browser.click("#save")
            inventory = file_of("marked-inventory.json")
            row = inventory["rows"][-1]
            assert row["name"] == "the <b>head</b>" and row["part"] == "the-b-head-b" and row["expected_labels"] == ["Rubber"], row
            first = row["hints"]["regions"][views[0]][0]
            assert len(first) == 4 and all(abs(a - b) < 0.01 for p, q in zip(first, OUTLINE) for a, b in zip(p, q)), first
            assert len(row["hints"]["regions"][views[1]][0]) >= 8
            state_material(browser)
            materials = file_of("marked-materials.json")
            assert [r["stated"] for r in materials["rows"]] == [{"label": "Foam", "E": 45000, "nu": 0.31, "rho": 321}], materials
            change_action(browser)
            action = file_of("marked-plan.json")["actions"][0]
            assert action["magnitude"] == 0.21 and [round(v, 9) for v in action["direction"]] == [0.6, 0, 0.8], action
            if shots:
                browser.evaluate("document.querySelector('#materials').scrollIntoView()")
                browser.screenshot(os.path.join(shots, "preview-edited.png"))
            others = [a for a in browser.requested() if not a.startswith((pathlib.Path(PAGE).as_uri(), "blob:", "data:"))]
            assert others == [], others
            assert browser.complaints() == [], browser.complaints()
        finally:
            browser.close()


main() if PAGE else save_to_server(sys.argv[1])
