#!/usr/bin/env python3
"""Checks docs/equations.md against the code: check-equations.py ROOT

Every file that the page names exists and has the symbols after it as words; every label is cited in one of its files
(`Eq. p2g`, `Table "mapping"`); every label that lib/ or tools/ cites is on the page; there are as many labels as the page
says that the paper has. Prints what does not hold, one line each; exit code 1 when there is any.
"""
import pathlib
import re
import sys

PAGE = "docs/equations.md"
LABEL = r'[("]*([a-z][a-z0-9-]*)(?![\w-])[)"]*'
# "Eq. decode", "Eq. (decode)", "Eqs. moments, supp-posteriorcenter, dispersion and quantile".
ONE = re.compile(r"\bEq\. " + LABEL)
SEVERAL = re.compile(r"\bEqs\. ((?:" + LABEL + r"(?:, and |, | and )?)+)")
TABLE = re.compile(r'\bTables? "([a-z][a-z0-9-]*)"(?:(?:,| and) "([a-z][a-z0-9-]*)")*')


def citations(text):
    """Labels that a source text cites; a comment that goes on in the next line is one text."""
    text = re.sub(r"\s*\n\s*(?://|#|\*)?\s*", " ", text)
    found = {"eq:" + label for label in ONE.findall(text)}
    for match in SEVERAL.finditer(text):
        found |= {"eq:" + label for label in re.findall(LABEL, match.group(1)) if label != "and"}
    for match in TABLE.finditer(text):
        found |= {"tab:" + label for label in re.findall(r'"([a-z][a-z0-9-]*)"', match.group(0))}
    return found


def rows_of(page):
    """(label, [(file, [symbol])]) of every row that names files."""
    for line in page.splitlines():
        cells = [cell.strip() for cell in line.strip().strip("|").split(" | ")]
        if not line.startswith("| ") or len(cells) != 3 or "](../" not in cells[2]:
            continue
        places = []
        for part in cells[2].split("; "):
            place = re.match(r"\[`([^`]+)`\]\(\.\./([^)]+)\): (.+)$", part)
            if place:
                places.append((place.group(1), re.findall(r"`([^`]+)`", place.group(3))))
                if place.group(1) != place.group(2):
                    yield cells[0], [(place.group(1) + " (linked as " + place.group(2) + ")", [])]
        yield cells[0].strip("`"), places


def main():
    root = pathlib.Path(sys.argv[1])
    wrong, labels = [], set()
    for label, places in rows_of((root / PAGE).read_text()):
        labelled = re.fullmatch(r"(eq|tab|alg):[a-z][a-z0-9-]*", label)
        if labelled and label in labels:
            wrong.append(f"{label}: stands there twice")
        labels.add(label)
        cited = False
        for file, symbols in places:
            if not (root / file).is_file():
                wrong.append(f"{label}: no file {file}")
                continue
            text = (root / file).read_text()
            cited = cited or label in citations(text)
            wrong += [f"{label}: no {s} in {file}" for s in symbols if not re.search(rf"\b{re.escape(s)}\b", text)]
            if not symbols:
                wrong.append(f"{label}: no symbol in {file}")
        if labelled and label[:4] != "alg:" and not cited:
            wrong.append(f"{label}: none of its files cites it")
    counts = re.search(r"\((\d+) equations, (\d+) tables, (\d+) algorithm", (root / PAGE).read_text())
    for kind, said in zip(("eq", "tab", "alg"), counts.groups()):
        rows = sum(label.startswith(kind + ":") for label in labels)
        if rows != int(said):
            wrong.append(f"{rows} rows of {kind}:, where the paper has {said}")
    for folder in ("lib", "tools"):
        for file in sorted(p for p in (root / folder).rglob("*") if p.suffix in {".h", ".cpp", ".cu", ".txt"}):
            for label in sorted(citations(file.read_text()) - labels):
                wrong.append(f"{file.relative_to(root)}: cites {label}, which is not on the page")
    for line in wrong:
        print(line)
    return 1 if wrong else 0


if __name__ == "__main__":
    sys.exit(main())
