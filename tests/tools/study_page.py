"""What respondents meet on a study page, in a headless Chromium: study_page.py STUDY_DIR FOLDER.

STUDY_DIR is what pm-eval study wrote; FOLDER gets the answers of three respondents as the page saves them, and screenshots.
One case must have a result that failed."""

import json
import os
import pathlib
import sys
import tempfile
import time

from browser import PATIENCE, Browser, find_chromium

STUDY, FOLDER = map(os.path.abspath, sys.argv[1:3])
KEY = json.load(open(os.path.join(STUDY, "key.json")))
PAGE = pathlib.Path(STUDY, "page", "index.html").as_uri()
METHODS = KEY["methods"]
CODES = {c["id"]: c["codes"] for c in KEY["cases"]}
DESKTOP, PHONE = (1280, 800), (390, 844)

CARDS = "[...document.querySelectorAll('.card')]"
VIDEOS = "[...document.querySelectorAll('.card video')]"
BOXES = CARDS + ".map(c => { const r = c.getBoundingClientRect(); return [r.x, r.y, r.width, r.height]; })"


def shown(browser):
    """(case, codes as they stand on the screen, choice or None), read from the page's state."""
    return browser.evaluate("[trials[position].case, trials[position].cards.map(c => c.code),"
                            " choices[trials[position].case] ?? null]")


def start(browser, name, press):
    browser.click("#respondent")
    browser.call("Input.insertText", text=name)
    press("#who button")
    browser.wait("!document.querySelector('#trial').hidden || !document.querySelector('#end').hidden")


def playing(browser):
    """Waits until every video of the trial has decoded frames and runs."""
    browser.wait(VIDEOS + ".every(v => v.readyState >= 2 && v.videoWidth > 0)")
    # Each shows more than its first frame at some time; they repeat, so a wait cannot miss it.
    browser.evaluate(VIDEOS + ".forEach(v => v.addEventListener('timeupdate', () => { if (v.currentTime > 0) v.ran = true; }))")
    browser.wait(VIDEOS + ".every(v => v.ran)")


def check_start(browser):
    assert browser.evaluate("document.querySelector('#last-key').textContent") == str(len(METHODS))
    browser.click("#who button")
    assert browser.evaluate("document.querySelector('#trial').hidden"), "a study began without a name"


def check_trial(browser, touch):
    case, codes, _ = shown(browser)
    boxes = browser.evaluate(BOXES)
    playing(browser)
    assert browser.evaluate(BOXES) == boxes, "cards move while their videos load"
    assert sorted(codes) == sorted(CODES[case]), (case, codes)
    assert len(boxes) == len(METHODS) and len({(w, h) for _, _, w, h in boxes}) == 1, boxes
    # Every card and button lies in the window, is large enough for a finger (44 pixels), and overlaps no other.
    width, height = PHONE if touch else DESKTOP
    buttons = browser.evaluate(BOXES.replace(".card", "#trial button"))
    for i, (x, y, w, h) in enumerate(buttons):
        assert x >= 0 and y >= 0 and x + w <= width and y + h <= height and min(w, h) >= 44, (x, y, w, h)
        for u, v, a, b in buttons[:i]:
            assert x >= u + a or u >= x + w or y >= v + b or v >= y + h, "targets overlap"
    assert browser.evaluate("document.documentElement.scrollWidth") <= width
    assert browser.evaluate("document.querySelector('#next').disabled")
    # A card has the video of its code, or the status of a failure; never both.
    sources = browser.evaluate(CARDS + ".map(c => [c.querySelector('video')?.getAttribute('src') ?? null,"
                               " c.querySelector('.status')?.textContent ?? null])")
    for code, (source, status) in zip(codes, sources):
        there = os.path.exists(os.path.join(STUDY, "page", "videos", code + ".mp4"))
        assert (source, status) == (("videos/" + code + ".mp4", None) if there else
                                    (None, "No video: this result could not be made.")), (source, status)
    return [status for _, status in sources].count(None) < len(sources)


def check_keys(browser, number):
    """Keys 1 to n choose, Enter does not go on before, Backspace comes back to the same choice."""
    before = shown(browser)
    browser.evaluate(VIDEOS + ".forEach(v => v.kept = true)")
    browser.key("Enter", "\r")
    assert shown(browser) == before, "went on without a choice"
    assert browser.evaluate(VIDEOS + ".every(v => v.kept)"), "the videos were loaded again"
    browser.key(str(len(METHODS) + 1), str(len(METHODS) + 1))
    assert shown(browser) == before, "a key without a card chose"
    browser.key("1", "1")
    assert shown(browser)[2] == before[1][0]
    browser.key(str(number), str(number))
    assert shown(browser)[2] == before[1][number - 1]
    assert browser.evaluate(CARDS + ".map(c => c.getAttribute('aria-checked') === 'true')").index(True) == number - 1
    # Space plays from the start.
    browser.evaluate(VIDEOS + ".forEach(v => { v.pause(); v.currentTime = v.duration / 2; v.again = false;"
                     " v.addEventListener('seeked', () => v.again = v.again || v.currentTime < v.duration / 2); })")
    browser.key(" ", " ")
    browser.wait(VIDEOS + ".every(v => v.again)")
    browser.key("Enter", "\r", modifiers=2)  # the browser's own
    assert shown(browser)[0] == before[0]
    browser.key("Enter", "\r")
    browser.key("Backspace")
    assert shown(browser) == [before[0], before[1], before[1][number - 1]], "going back lost something"
    # A button that has the focus does what it says, whatever Enter means elsewhere.
    browser.evaluate("document.querySelector('#replay').focus()")
    browser.key("Enter", "\r")
    assert shown(browser)[0] == before[0]
    browser.evaluate("document.querySelector('#next').focus()")
    browser.key("Enter", "\r")


def save(browser, name, press):
    press("#save")
    path = os.path.join(FOLDER, "answers-" + name + ".json")
    end = time.monotonic() + PATIENCE
    while not os.path.exists(path) and time.monotonic() < end:
        time.sleep(0.05)
    return json.load(open(path))


def respond(browser, name, touch, first_key):
    """One respondent's whole visit. Chooses the card number `first_key`, then the next number, and so on."""
    press = browser.tap if touch else browser.click
    browser.open(PAGE, *(PHONE if touch else DESKTOP), touch=touch)
    check_start(browser)
    start(browser, name, press)
    order, expected, failures = [], {}, 0
    for i in range(len(KEY["cases"])):
        failures += check_trial(browser, touch)
        case, codes, _ = shown(browser)
        number = (first_key - 1 + i) % len(codes) + 1
        order.append([case, codes])
        expected[case] = codes[number - 1]
        browser.screenshot(os.path.join(FOLDER, f"{name}-{i}.png"))
        if touch:
            press(f".card:nth-child({number})")
            assert shown(browser)[2] == codes[number - 1]
            press("#next")
        else:
            check_keys(browser, number)
    assert failures == 1, "the failed result has one card"
    assert not browser.evaluate("document.querySelector('#end').hidden")
    browser.screenshot(os.path.join(FOLDER, f"{name}-end.png"))
    # Back from the end, and on again.
    press("#again")
    assert shown(browser)[0] == order[-1][0]
    press("#back")
    assert shown(browser)[0] == order[-2][0]
    press("#next")
    press("#next")
    answers = save(browser, name, press)
    assert answers["respondent"] == name and answers["token"] == KEY["token"]
    assert [[a["case"], a["order"]] for a in answers["answers"]] == order
    assert {a["case"]: a["choice"] for a in answers["answers"]} == expected
    check_blind(browser)
    return order, expected


def check_return(browser, name, order, expected):
    """A respondent who comes back finds the end, the same order and the same choices."""
    browser.open(PAGE, *DESKTOP)
    start(browser, name, browser.click)
    assert not browser.evaluate("document.querySelector('#end').hidden")
    assert browser.evaluate("trials.map(t => [t.case, t.cards.map(c => c.code)])") == order
    assert browser.evaluate("choices") == expected
    # One who had left in the middle goes on there. What was kept but never on the screen does not count.
    kept = {order[0][0]: expected[order[0][0]], order[1][0]: "elsewhere"}
    browser.evaluate(f"localStorage.setItem(storageKey(), JSON.stringify({json.dumps(kept)}))")
    browser.open(PAGE, *DESKTOP)
    start(browser, name, browser.click)
    assert shown(browser) == [order[1][0], order[1][1], None]
    browser.evaluate("localStorage.setItem(storageKey(), 'no JSON')")
    browser.open(PAGE, *DESKTOP)
    start(browser, name, browser.click)
    assert shown(browser)[0] == order[0][0]


def check_blind(browser):
    """Neither what the page holds nor what it asks for names a method; and it asks for nothing elsewhere."""
    addresses = browser.requested()
    folder = pathlib.Path(STUDY, "page").as_uri()
    assert any(a.endswith(".mp4") for a in addresses)
    assert all(a.startswith(folder) or a.startswith("blob:file") for a in addresses), addresses
    told = browser.evaluate("document.documentElement.outerHTML + JSON.stringify([trials, choices, {...localStorage}])")
    for method in METHODS:
        assert method not in told and not any(method in a for a in addresses), method
    assert browser.complaints() == [], browser.complaints()


def check_orders(browser):
    """Orders over many respondents: every card stands first about equally often, and many orders occur."""
    plans = browser.evaluate("Array.from({length: 400}, (_, i) => Logic.plan(study, 'r' + i)"
                             ".map(t => [t.case, t.cards.map(c => c.code)]))")
    assert plans == browser.evaluate("Array.from({length: 400}, (_, i) => Logic.plan(study, 'r' + i)"
                                     ".map(t => [t.case, t.cards.map(c => c.code)]))")
    assert len({json.dumps(p) for p in plans}) > 100
    first = {}
    for plan in plans:
        assert sorted(case for case, _ in plan) == sorted(CODES)
        for case, codes in plan:
            assert sorted(codes) == sorted(CODES[case])
            first[codes[0]] = first.get(codes[0], 0) + 1
    share = 400 / len(METHODS)
    for case, codes in CODES.items():
        for code in codes:  # five standard deviations of a binomial count
            assert abs(first.get(code, 0) - share) < 5 * (share * (1 - 1 / len(METHODS))) ** 0.5, (case, code, first)


def check_layout(browser):
    """Cards of a trial fit every window, and are of useful size."""
    for count in range(2, 10):
        for width, height in ((366, 640), (800, 300), (1256, 620), (1896, 900)):
            for aspect in (0.5, 1, 16 / 9):
                got = browser.evaluate(f"Logic.layout({count}, {width}, {height}, {aspect}, 10, 44)")
                columns, card = got["columns"], got["card"]
                assert columns * card + 10 * (columns - 1) <= width, (count, width, got)
                rows = -(-count // columns)
                assert rows * (card / aspect + 44) + 10 * (rows - 1) <= height or card <= 140, (count, height, got)


def check_broken_video(browser):
    """A video that cannot be played says so and does not hold up the others."""
    browser.open(PAGE, *DESKTOP)
    # One trial without a failure, and one of its addresses leads nowhere.
    browser.evaluate("study.trials = study.trials.filter(t => t.cards.every(c => c.video));"
                     "study.trials[0].cards[0].code = 'nowhere'; study.trials.length = 1")
    start(browser, "Zoe", browser.click)
    browser.wait("document.querySelector('.status')?.textContent.startsWith('This video cannot be played here')")
    playing(browser)
    browser.key("1", "1")
    assert not browser.evaluate("document.querySelector('#next').disabled")


def main():
    os.makedirs(FOLDER, exist_ok=True)
    with tempfile.TemporaryDirectory(ignore_cleanup_errors=True) as profile:
        browser = Browser(find_chromium(), profile)
        try:
            browser.call("Browser.setDownloadBehavior", behavior="allow", downloadPath=FOLDER)
            seen = {}
            for i, (name, touch) in enumerate((("Ada", False), ("Ben", True), ("Eve", False))):
                seen[name] = respond(browser, name, touch, 1 + i)
            assert len({json.dumps(order) for order, _ in seen.values()}) > 1, "everyone has the same order"
            check_return(browser, "Ada", *seen["Ada"])
            check_orders(browser)
            check_layout(browser)
            check_broken_video(browser)
        finally:
            browser.close()


main()
