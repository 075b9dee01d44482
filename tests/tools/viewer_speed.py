"""How fast pages of pm-render --html are in a headless Chromium, which draws in software: viewer_speed.py PAGE...

Prints a line per page: Gaussians and frames, the mean milliseconds of a frame for decoding and sorting (on the worker) and for
uploading, and the frames a second that were drawn at 800x800 while it played. How many a GPU draws is not measured by this."""

import pathlib
import sys
import tempfile

from browser import Browser, find_chromium

LOADED = "typeof viewer !== 'undefined' && viewer.state.loaded === header.frames.length"
# Pictures that were drawn and finished within five seconds of playing.
PLAY = """(async () => {
  const gl = viewer.canvas.getContext("webgl2"), before = viewer.statistics.draw.length, began = performance.now(), pixel = new Uint8Array(4);
  viewer.setPlaying(true);
  while (performance.now() - began < 5000) {
    await new Promise(requestAnimationFrame);
    gl.readPixels(0, 0, 1, 1, gl.RGBA, gl.UNSIGNED_BYTE, pixel);
  }
  viewer.setPlaying(false);
  return 1000 * (viewer.statistics.draw.length - before) / (performance.now() - began);
})()"""
MEANS = "Object.fromEntries(Object.entries(viewer.statistics).map(([k, v]) => [k, v.reduce((a, b) => a + b, 0) / Math.max(1, v.length)]))"

for page in sys.argv[1:]:
    with tempfile.TemporaryDirectory(ignore_cleanup_errors=True) as profile:
        browser = Browser(find_chromium(), profile)
        try:
            browser.open(pathlib.Path(page).resolve().as_uri() + "#bare", 800, 800)
            browser.wait(LOADED)
            rate = browser.evaluate(PLAY)
            mean = browser.evaluate(MEANS)
            count, frames = browser.evaluate("[header.gaussians, header.frames.length]")
        finally:
            browser.close()
    print(f"{page}: {count} Gaussians, {frames} frames: decode {mean['decode']:.1f} ms, sort {mean['sort']:.1f} ms, upload {mean['upload']:.1f} ms a frame; "
          f"{rate:.1f} frames a second, drawn in software")
