"""A page of pm-render --html in a headless Chromium: viewer_page.py PAGE FRAMES_DIR [SCREENSHOTS_DIR].

FRAMES_DIR holds frames of pm-render --png in the same cameras, without a floor; those that are there are compared. Prints what
was measured, as JSON."""

import base64
import json
import os
import pathlib
import re
import sys
import tempfile

from browser import Browser, find_chromium

PAGE, FRAMES = (os.path.abspath(a) for a in sys.argv[1:3])
SHOTS = sys.argv[3] if len(sys.argv) > 3 else None
LEAST = 34  # dB
LOADED = "typeof viewer !== 'undefined' && viewer.state.loaded === header.frames.length"

# PSNR of the canvas against a picture, and how many of the pixels are not white.
COMPARE = """(async png => {
  const image = new Image();
  image.src = "data:image/png;base64," + png;
  await image.decode();
  const pixels = source => {
    const canvas = Object.assign(document.createElement("canvas"), {width: image.width, height: image.height});
    const context = canvas.getContext("2d", {willReadFrequently: true});
    context.drawImage(source, 0, 0);
    return context.getImageData(0, 0, image.width, image.height).data;
  };
  if (viewer.canvas.width !== image.width || viewer.canvas.height !== image.height) return "another size";
  const a = pixels(image), b = pixels(viewer.canvas);
  let sum = 0, drawn = 0;
  for (let i = 0; i < a.length; i += 4) {
    for (let c = 0; c < 3; ++c) sum += (a[i + c] - b[i + c]) ** 2;
    drawn += a[i] + a[i + 1] + a[i + 2] < 750;
  }
  return [Math.min(99, 10 * Math.log10(255 * 255 / (sum / (a.length / 4 * 3)))), drawn / (a.length / 4)];
})"""
# The colours on the canvas, coarsely: what is seen changes them.
LOOK = """(() => {
  const canvas = Object.assign(document.createElement("canvas"), {width: 64, height: 64});
  const context = canvas.getContext("2d", {willReadFrequently: true});
  context.drawImage(viewer.canvas, 0, 0, 64, 64);
  return Array.from(context.getImageData(0, 0, 64, 64).data);
})()"""


def difference(a, b):
    return sum(abs(x - y) for x, y in zip(a, b)) / len(a)


def seek(browser, frame):
    browser.evaluate(f"viewer.seek({frame})")
    browser.wait("viewer.settled()")


def compare_frames(browser, measured):
    browser.open(pathlib.Path(PAGE).as_uri() + "#bare", 800, 800)
    browser.wait("typeof viewer !== 'undefined' && viewer.settled()")
    measured["psnr"] = {}
    for name in sorted(os.listdir(FRAMES)):
        frame = int(re.fullmatch(r"frame_(\d+)\.png", name)[1])
        seek(browser, frame)
        with open(os.path.join(FRAMES, name), "rb") as file:
            psnr, drawn = browser.evaluate(f"({COMPARE})({json.dumps(base64.b64encode(file.read()).decode())})")
        assert psnr >= LEAST, f"frame {frame}: {psnr} dB"
        assert drawn > 0.01, f"frame {frame} is empty"
        measured["psnr"][frame] = round(psnr, 2)
    measured["milliseconds"] = browser.evaluate(
        "Object.fromEntries(Object.entries(viewer.statistics).map(([k, v]) => [k, v.reduce((a, b) => a + b, 0) / v.length]))")
    check_quiet(browser)


def check_quiet(browser):
    """Nothing was asked for but the page itself and its own worker; nothing went wrong."""
    others = [a for a in browser.requested() if not a.startswith((pathlib.Path(PAGE).as_uri(), "blob:", "data:"))]
    assert others == [], others
    assert browser.complaints() == [], browser.complaints()


def check_hands(browser):
    """Play, scrub, orbit, zoom, one row alone, particles, colours: each changes what is seen."""
    browser.open(pathlib.Path(PAGE).as_uri(), 1280, 800)
    browser.wait(LOADED)
    browser.wait("viewer.state.playing && viewer.state.time > 0.5")
    browser.key(" ", " ")
    assert not browser.evaluate("viewer.state.playing")
    seek(browser, 0)
    browser.key("ArrowRight")
    browser.wait("viewer.settled()")
    assert browser.evaluate("viewer.state.time") == 1
    browser.evaluate("(s => { s.value = header.frames.length - 1; s.dispatchEvent(new Event('input')); })(document.querySelector('.v-scrub'))")
    browser.wait("viewer.settled()")
    assert browser.evaluate("viewer.state.time") == browser.evaluate("header.frames.length - 1")
    seek(browser, 0)
    last = browser.evaluate(LOOK)

    def changes(what, act, least=0.05):
        nonlocal last
        act()
        browser.wait("viewer.settled()")
        now = browser.evaluate(LOOK)
        assert difference(last, now) > least, f"{what} changes nothing: {difference(last, now)}"
        last = now

    changes("dragging", lambda: browser.drag(".v-canvas", 120, 30))
    assert browser.evaluate("document.querySelector('[aria-label=Camera]').value") == "own"
    changes("zooming", lambda: browser.evaluate("viewer.zoom(0.7)"))
    changes("panning", lambda: browser.evaluate("viewer.pan(80, 0)"))
    changes("the key r", lambda: browser.key("r", "r"))
    for key in "cp":
        changes("the key " + key, lambda: browser.key(key, key), 0.01)
    changes("the key b", lambda: [browser.key("b", "b") for _ in range(3)])  # from as it is to black
    browser.evaluate("document.querySelector('[aria-label=Background]').value = 'white'")
    rows = browser.evaluate("header.rows.length")
    if rows > 1:
        changes("one part alone", lambda: browser.click(".v-chip"), 0.01)
        changes("all parts again", lambda: browser.click(".v-chip"), 0.01)
    # The number of a key for every row.
    browser.key("1", "1")
    assert browser.evaluate("viewer.state.alone") == 0
    browser.key("0", "0")
    assert browser.evaluate("viewer.state.alone") == -1
    # Every control has a name.
    assert browser.evaluate("[...document.querySelectorAll('button, select, input')].every(e => e.textContent.trim() || e.getAttribute('aria-label'))")
    check_quiet(browser)


def check_layout(browser):
    for width, height, dark in ((1280, 800, False), (390, 844, True), (1280, 800, True), (390, 844, False)):
        browser.open(pathlib.Path(PAGE).as_uri(), width, height, touch=width < 500, dark=dark)
        browser.wait(LOADED)
        browser.evaluate("viewer.setPlaying(false)")
        seek(browser, browser.evaluate("header.frames.length >> 1"))
        assert browser.evaluate("document.documentElement.scrollWidth") <= width
        assert browser.evaluate("document.documentElement.scrollHeight") <= height
        assert browser.evaluate("viewer.canvas.getBoundingClientRect().height") > height * 0.5
        if SHOTS:
            browser.screenshot(os.path.join(SHOTS, f"viewer-{width}-{'dark' if dark else 'light'}.png"))


def check_damage(browser):
    """A stream that was cut says so instead of showing nothing."""
    with open(PAGE, encoding="utf-8") as file:
        text = file.read()
    start = text.index('id="stream">') + len('id="stream">')
    end = text.index("</script>", start)
    cut = (end - start) // 2 // 4 * 4
    with tempfile.TemporaryDirectory() as folder:
        broken = os.path.join(folder, "broken.html")
        with open(broken, "w", encoding="utf-8") as file:
            file.write(text[:start + cut] + text[end:])
        browser.open(pathlib.Path(broken).as_uri(), 640, 480)
        browser.wait("document.querySelector('.v-word').textContent.startsWith('The stream cannot be read')")


def main():
    measured = {"bytes": os.path.getsize(PAGE)}
    with tempfile.TemporaryDirectory(ignore_cleanup_errors=True) as profile:
        browser = Browser(find_chromium(), profile)
        try:
            compare_frames(browser, measured)
            check_hands(browser)
            check_layout(browser)
            check_damage(browser)
        finally:
            browser.close()
    print(json.dumps(measured))


main()
