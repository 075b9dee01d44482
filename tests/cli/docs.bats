# The documentation: what it links to and what it names is there.
load common

pages() { printf '%s\n' README.md docs/*.md schemas/*.md; }

# The text of a page without its fenced and indented code.
prose() { # PAGE
  awk '/^ *```/ { fenced = !fenced; next } !fenced && !/^    [^ |*-]/' "$1"
}

# The anchors of a page as GitHub makes them of headings: lower case, without punctuation, hyphens for spaces. A second
# heading of the same words gets -1.
anchors() { # PAGE
  prose "$1" | sed -nE 's/^#+ +(.*)/\1/p' | sed -E 's/\[([^]]*)\]\([^)]*\)/\1/g' | python3 -c '
import collections, re, sys
seen = collections.Counter()
for line in sys.stdin:
    slug = re.sub(r"[^\w\- ]", "", line.strip().lower()).replace(" ", "-")
    print(slug + ("-%d" % seen[slug] if seen[slug] else ""))
    seen[slug] += 1'
}

# What is wrong with the relative links of a page, one line each.
broken_links() { # PAGE
  local link file
  prose "$1" | perl -ne 'print "$1\n" while /\]\(([^)]+)\)/g' | sort -u | while IFS= read -r link; do
    [[ $link =~ ^(https?|mailto): ]] && continue
    file=$1
    [[ $link = \#* ]] || file=$(dirname "$1")/${link%%#*}
    if [ ! -e "$file" ]; then
      echo "$1: $link: no such file"
    elif [[ $link = *\#* ]] && ! anchors "$file" | grep -xF -- "${link#*#}" >/dev/null; then
      echo "$1: $link: no such heading"
    fi
  done
}

# Paths of the tree that a page names and that are not there. NAME, ROOM and other words in capitals stand for any; a
# pattern (`lib/x.*`) must match something.
missing_paths() { # PAGE
  local path
  perl -ne 'print "$1\n" while m{(?<![\w/.-])((?:lib|schemas|examples|pipelines|tests|tools|docs)/[\w./*-]*[\w/*])}g' "$1" | sort -u |
    while IFS= read -r path; do
      [[ $path =~ (^|/)[A-Z]+(\.|/|_|$) || $path =~ _NAME ]] && [ ! -e "$path" ] && continue
      compgen -G "$path" >/dev/null || echo "$1: $path is not there"
    done
}

setup() { cd "$root"; }

@test "docs: every relative link and anchor leads somewhere" {
  for page in $(pages); do broken_links "$page"; done >"$BATS_TEST_TMPDIR/broken"
  cat "$BATS_TEST_TMPDIR/broken"
  [ ! -s "$BATS_TEST_TMPDIR/broken" ]
}

@test "docs: every file that a page names is there" {
  for page in $(pages); do missing_paths "$page"; done >"$BATS_TEST_TMPDIR/missing"
  cat "$BATS_TEST_TMPDIR/missing"
  [ ! -s "$BATS_TEST_TMPDIR/missing" ]
}

@test "docs: index.md leads to every page, and every picture is shown somewhere" {
  for page in docs/*.md; do
    [ "$page" = docs/index.md ] || grep -qF "($(basename "$page"))" docs/index.md || { echo "index.md: no $page"; false; }
  done
  for picture in docs/images/*; do
    grep -qF "images/$(basename "$picture")" README.md docs/*.md || { echo "$picture is shown nowhere"; false; }
  done
}

@test "docs: a broken link, a missing heading and a missing file are found" {
  mkdir -p "$BATS_TEST_TMPDIR/tree/docs" "$BATS_TEST_TMPDIR/tree/lib/base"
  cd "$BATS_TEST_TMPDIR/tree"
  touch lib/base/error.h
  printf '# A page\n\n## The `cfl` step, twice\n\n## The `cfl` step, twice\n' >docs/a.md
  printf '%s\n' '[right](a.md#the-cfl-step-twice-1) [right](#b) [gone](c.md) [gone](a.md#the-step)' '# b' '`lib/base/error.*`' \
    '`lib/base/NAME.h` and `lib/base/eror.h`' >docs/b.md
  [ "$(broken_links docs/b.md | wc -l)" -eq 2 ]
  broken_links docs/b.md | grep -qF 'c.md: no such file'
  broken_links docs/b.md | grep -qF 'a.md#the-step: no such heading'
  [ "$(missing_paths docs/b.md)" = "docs/b.md: lib/base/eror.h is not there" ]
}

@test "docs: scenes.md has a row for every field of the run specification" {
  run python3 - "$root" <<'EOF'
import json, re, sys
page = open(sys.argv[1] + "/docs/scenes.md").read()
named = set()
for row in page.splitlines():
    if not row.startswith("| `"):
        continue
    section = ""
    for name in re.findall(r"`([^`]+)`", row.split("|")[1]):  # `profile.foam_yield`, `.foam_viscosity`
        if not name.startswith("."):
            section = name.split(".")[0]
        named.add(section + name if name.startswith(".") else name.replace("[]", ""))
properties = json.load(open(sys.argv[1] + "/schemas/run.json"))["properties"]
for name, schema in properties.items():
    for field in [name + "." + field for field in schema.get("properties", {})] or [name]:
        if name not in ("schema", "provenance") and field not in named:
            print(field)
EOF
  [ "$status" -eq 0 ]
  [ "$output" = "" ]
}
