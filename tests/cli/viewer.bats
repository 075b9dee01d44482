#!/usr/bin/env bats
# The 4D viewer, pm-render --html: its file, and the page in a browser.
bats_require_minimum_version 1.5.0
load tiny

setup_file() { make_tiny_run; }
setup() { enter_tiny_run; }

viewer() { render --out video/x.mp4 --inventory inventory.json --html viewer.html "$@"; }

@test "viewer: one file that names no address, and equal bytes whatever the threads" {
  viewer --candidate candidates/support-stiff.json
  grep -q "Content-Security-Policy\" content=\"default-src 'none'" viewer.html
  refute grep -nE '(src|href)="?(http|//)|url\(' viewer.html
  sha256sum viewer.html >sum
  viewer --candidate candidates/support-stiff.json --threads 1
  sha256sum -c sum
}

@test "viewer: names are text, whatever they say" {
  sed -i 's|"name": "candy"|"name": "</script><script>alert(1)</script><b>"|' inventory.json
  grep -q '<script>alert' inventory.json
  viewer
  [ "$(grep -o '<script' viewer.html | wc -l)" -eq 3 ]
  [ "$(grep -o '</script' viewer.html | wc -l)" -eq 3 ]
  refute grep -q '<script>alert' viewer.html
}

@test "viewer: what does not fit is refused" {
  fails_with 3 viewer --cameras missing.json -- missing.json
  fails_with 2 render --html viewer.txt -- .html
  echo '{' >broken.json
  fails_with 3 viewer --candidate broken.json -- broken.json
}

@test "viewer: a page in Chromium: equal to pm-render's frames, hands, layout, no request" {
  python3 "$root/tests/tools/browser.py" || skip "no Chromium: apt-get install chromium"
  viewer --candidate candidates/support-stiff.json --floor none --png frames
  rm -f frames/frame_000[1367]*.png
  python3 "$root/tests/tools/viewer_page.py" viewer.html frames ${SCREENSHOTS:-}
}
