"""The deterministic stages of the paper, recomputed from its text: evidence, posterior, guards, statistics.

Python standard library only, and nothing of lib/: this is the second opinion that tests/cli/golden.bats holds the tools
against. Section names are those of the paper's appendix; "readings" is the project's list of decisions where it is
silent (docs/method.md repeats them).
"""

import math

# Table "mapping": label -> (branch, E range, nu bound, rho), in the printed order.
LABELS = {
    "Wood": ("Metal", (1e8, 2e10), (0.25, 0.45), 700.0),
    "Metal": ("Metal", (1e9, 3e11), (0.20, 0.35), 7800.0),
    "Plastic": ("Metal", (1e6, 5e9), (0.30, 0.45), 1200.0),
    "Glass": ("Metal", (1e9, 1e11), (0.18, 0.30), 2500.0),
    "Fabric": ("Foam", (1e4, 1e8), (0.20, 0.45), 500.0),
    "Leather": ("Foam", (1e5, 1e9), (0.30, 0.49), 900.0),
    "Ceramic": ("Metal", (1e8, 1e11), (0.15, 0.35), 2500.0),
    "Stone": ("Metal", (1e8, 1e11), (0.10, 0.35), 2600.0),
    "Rubber": ("Jelly", (1e4, 1e8), (0.40, 0.499), 1100.0),
    "Paper": ("Foam", (1e5, 1e9), (0.20, 0.45), 800.0),
    "Sand": ("Sand", (1e3, 1e7), (0.20, 0.45), 1600.0),
    "Snow": ("Snow", (1e3, 1e7), (0.10, 0.35), 300.0),
    "Plasticine": ("Plasticine", (1e3, 1e7), (0.25, 0.49), 2000.0),
    "Foam": ("Foam", (1e3, 1e7), (0.10, 0.45), 100.0),
}
ELASTIC = [m for m, prior in LABELS.items() if prior[0] == "Metal"]
RIGID = {"Wood", "Metal", "Glass", "Ceramic", "Stone"}

# "The fixed lookup", rule by rule.
ROLE_RULES = [
    ("head/blade/tip/edge/impact/metal", [("Metal", 0.75)]),
    ("handle/grip/shaft", [("Wood", 0.55), ("Plastic", 0.45)]),
    ("wheel/tire/tyre/sole", [("Rubber", 0.80)]),
    ("cushion/pad/pillow/foam", [("Foam", 0.75)]),
    ("cloth/fabric/lace/upper", [("Fabric", 0.65)]),
    ("plate/bowl/ceramic", [("Ceramic", 0.55), ("Plastic", 0.35)]),
    ("frosting/cream/cake/soft", [("Foam", 0.55), ("Plasticine", 0.35)]),
]


def clip(x, lo, hi):
    return min(max(x, lo), hi)


def text(*fields):
    """Readings: lower case, underscores as spaces, joined by one space."""
    return " ".join(fields).lower().replace("_", " ")


def has(haystack, tokens):
    return any(token in haystack for token in tokens)


def canonical(name):
    for label in LABELS:
        if label.lower() == name.lower():
            return label
    return None


def E_default(label):
    lo, hi = LABELS[label][1]
    return math.sqrt(lo * hi)


def nu_default(label):
    lo, hi = LABELS[label][2]
    return 0.5 * (lo + hi)


def role_evidence(row):
    """Sums and maxima of the matching rules' confidences."""
    sums, maxima = {}, {}
    where = text(row["name"], row.get("structural_role", ""))
    for words, labels in ROLE_RULES:
        if not has(where, words.split("/")):
            continue
        for label, confidence in labels:
            sums[label] = sums.get(label, 0.0) + confidence
            maxima[label] = max(maxima.get(label, 0.0), confidence)
    return sums, maxima


def valid_answers(records):
    """VLM records that count: successful, not abstaining, finite confidence, probabilities with a positive sum."""
    valid = []
    for record in records:
        probabilities = {canonical(m): p for m, p in record["probabilities"].items()}
        total = sum(probabilities.values())
        if record["status"] != "success" or record.get("abstain", False) or record["confidence"] is None or total <= 0:
            continue
        views = {v.lower() for v in record["views"]} & {"front", "right", "back", "left"}
        valid.append(
            {
                "confidence": record["confidence"],
                "views": len(views),
                "p": {m: p / total for m, p in probabilities.items()},
            }
        )
    return valid


def sources_of(row, crops, answers, whole_label, expected):
    """The weighted evidence of every source, in the insertion order schema, crop, VLM, role, whole."""
    sources = {}
    if expected:
        sources["schema"] = {m: 0.25 / len(expected) for m in expected}
    used = [c for c in crops if c.get("valid", True)]
    sums = {}
    for crop in used:
        for name, value in crop.get("evidence", {}).items():
            label = canonical(name)
            sums[label] = sums.get(label, 0.0) + value
    if sums:
        sources["crop"] = {m: 0.35 * (s / len(used)) for m, s in sums.items()}
    sums = {}
    for answer in answers:
        for label, p in answer["p"].items():
            sums[label] = sums.get(label, 0.0) + answer["confidence"] * p
    if sums:
        sources["vlm"] = {m: 0.30 * (s / len(answers)) for m, s in sums.items()}
    role = role_evidence(row)[0]
    if role:
        sources["role"] = {m: 0.10 * s for m, s in role.items()}
    if whole_label:
        sources["whole"] = {whole_label: 0.05}
    return sources


def posterior_of(scores):
    """P in the stored order: descending, ties by insertion, labels never inserted last in table order."""
    total = sum(scores.values())
    order = list(scores) + [m for m in LABELS if m not in scores]
    P = {m: scores.get(m, 0.0) / total for m in order}
    return dict(sorted(P.items(), key=lambda entry: -entry[1]))  # sorted() is stable


def expected_guard(P, mode, expected, seen):
    """ExpGuard, Eq. supp-materialguard."""
    if not expected:
        seen.add("expected: empty set")
        return mode, False
    best = expected[0]
    for label in expected:
        if P[label] > P[best]:
            best = label
    cap = max(1.75 * P[best], P[best] + 0.20)
    tests = {"mode is expected": mode not in expected, "P below 0.18": P[best] >= 0.18, "above the cap": P[mode] <= cap}
    note(seen, "expected", tests)
    return (best, True) if all(tests.values()) else (mode, False)


def note(seen, guard, tests):
    failed = [name for name, passed in tests.items() if not passed]
    if not failed:
        seen.add(guard + ": applied")
    elif len(failed) == 1:
        seen.add(guard + ": only " + failed[0])


def multi_view_guard(P, before, expected, R, answers, seen):
    best, chosen = -1.0, None
    eligible = 0
    for answer in answers:
        v = max(answer["p"], key=lambda m: answer["p"][m])  # the first of equals: record order
        top = answer["p"][v]
        tests = {
            "confidence": answer["confidence"] >= 0.60,
            "views": answer["views"] >= 3,
            "top probability": top >= 0.75,
            "v is not expected": v in expected,
            "v is the label before": v != before,
            "R(v) below 0.50": R.get(v, 0.0) >= 0.50,
            "R(v) below R(m) + 0.10": R.get(v, 0.0) >= R.get(before, 0.0) + 0.10,
            "P(v) below 0.20": P[v] >= 0.20,
            "P(m) above 1.50 P(v)": P[before] <= 1.50 * P[v],
            "P(m) - P(v) above 0.18": P[before] - P[v] <= 0.18,
        }
        note(seen, "multi-view", tests)
        product = answer["confidence"] * top * P[v]
        if all(tests.values()):
            eligible += 1
            if product > best:
                best, chosen = product, v
    if eligible > 1:
        seen.add("multi-view: several eligible")
    return (chosen, True) if chosen else (before, False)


def elastic_guard(P, before, expected, row, answers, seen):
    words = "".join(
        c if c.isalnum() else " " for c in text(row.get("physics_group", ""), row.get("structural_role", ""))
    )
    words = set(words.split())
    structural = (
        bool(words & {"support", "supporting", "structural", "rigid", "loadbearing"}) or {"load", "bearing"} <= words
    )
    fraction = sum(m in ELASTIC for m in expected) / len(expected) if expected else 1.0
    strong = False
    for answer in answers:
        on_elastic = [p for m, p in answer["p"].items() if m in ELASTIC]
        tests = {
            "views": answer["views"] >= 3,
            "confidence": answer["confidence"] >= 0.60,
            "total": sum(on_elastic) >= 0.70,
            "maximum": max(on_elastic, default=0.0) >= 0.50,
        }
        note(seen, "strong record", tests)
        strong = strong or all(tests.values())
    tests = {
        "already elastic": before not in ELASTIC,
        "not structural": structural,
        "fraction below 0.50": fraction >= 0.50,
        "no strong record": strong,
    }
    note(seen, "elastic-solid", tests)
    if not all(tests.values()):
        return before, False
    if not expected:
        seen.add("elastic-solid: applied without expected labels")
    return next(m for m in P if m in ELASTIC), True


def decoded(crop):
    """Eq. decode, or the crop's own values; None where not finite."""
    x = y = None
    if crop.get("E") is not None:
        x = math.log10(crop["E"])
    elif crop.get("E_mean") is not None:
        x = math.log10(0.1 * 10.0 ** (2.456477 * crop["E_mean"] + 7.387210))
    if crop.get("nu") is not None:
        y = crop["nu"]
    elif crop.get("nu_mean") is not None:
        y = 0.111 * crop["nu_mean"] + 0.398
    return x, y


def moments(crops, label):
    """Eq. moments: the E and the nu records with their weights for the selected label."""
    E, nu, a, s = [], [], [], []
    for crop in crops:
        if not crop.get("valid", True):
            continue
        evidence = {canonical(m): e for m, e in crop.get("evidence", {}).items()}
        w = max(0.05, evidence[label]) if label in evidence else 0.1
        x, y = decoded(crop)
        if x is not None and crop.get("E_uncertainty") is not None:
            E.append((w, x))
            a.append(crop["E_uncertainty"])
        if y is not None:
            nu.append((w, y))
            if crop.get("nu_uncertainty") is not None:
                s.append(crop["nu_uncertainty"])
    return E, nu, a, s


def weighted(pairs):
    return sum(w * x for w, x in pairs) / sum(w for w, _ in pairs)


def mean(values, default):
    return sum(values) / len(values) if values else default


def evidence_of(row, observations, whole_label, mask_confidence, seen):
    """psi_r of one row."""
    crops, vlm = observations.get("crops", []), observations.get("vlm", [])
    if row.get("residual", False):
        expected, sources, crops, answers, guards = [], {}, [], [], []
        scores = {"Plastic": 1.0}
        fallback = True
    else:
        expected = []
        for name in row.get("expected_labels", []):
            label = canonical(name)
            if label and label not in expected:
                expected.append(label)
        answers = valid_answers(vlm)
        sources = sources_of(row, crops, answers, whole_label, expected)
        scores = {}
        for source in sources.values():
            for label, value in source.items():
                scores[label] = scores.get(label, 0.0) + value
        fallback = sum(scores.values()) <= 0
        if fallback:
            scores = {"Plastic": 1.0}
            seen.add("fallback")
    P = posterior_of(scores)
    label = next(iter(P))
    if not row.get("residual", False):
        R = role_evidence(row)[1]
        m1, applied1 = expected_guard(P, label, expected, seen)
        m2, applied2 = multi_view_guard(P, m1, expected, R, answers, seen)
        m3, applied3 = elastic_guard(P, m2, expected, row, answers, seen)
        guards = [("expected", applied1, m1), ("multi-view", applied2, m2), ("elastic-solid", applied3, m3)]
        label = m3
    branch, E_range, nu_range, _ = LABELS[label]
    E, nu, a, s = moments(crops, label)
    e_mean = weighted(E) if E else math.log10(E_default(label))
    spread = 0.25
    if len(E) >= 2:
        spread = max(0.25, math.sqrt(weighted([(w, (x - e_mean) * (x - e_mean)) for w, x in E])))
    e_post = math.log10(clip(10.0**e_mean, *E_range))
    nu_mean = weighted(nu) if nu else nu_default(label)
    H = -sum(p * math.log(p) for p in P.values() if p > 0)
    h = min(0.5, H / max(1.0, math.log(14)))
    sigma_e = max(0.10, 0.50 * mean(a, 0.35) + 0.35 * spread + 0.15 * h)
    mask = mask_confidence if mask_confidence > 0 else 0.7
    seen.add("mask: " + ("sentinel" if mask_confidence <= 0 else "floor" if mask_confidence < 0.2 else "stored"))
    return {
        "sources": sources,
        "scores": scores,
        "fallback": fallback,
        "P": P,
        "guards": guards,
        "label": label,
        "confidence": P[label],
        "e": e_post,
        "e_mean": e_mean,
        "spread": spread,
        "sigma_e": sigma_e,
        "a": mean(a, 0.35),
        "nu": clip(nu_mean, *nu_range),
        "nu_mean": nu_mean,
        "sigma_nu": max(0.02, mean(s, 0.06)),
        "H": H,
        "E_records": len(E),
        "nu_records": len(nu),
        "gamma": clip(P[label] / (1 + sigma_e) * max(0.2, mask), 0, 1),
    }


def whole_object(observations):
    """(source, label or None, branch, E, nu, rho): the auxiliary record, or its fixed fallback."""
    fallback = ("fallback", None, "Plasticine", 5e5, 0.476, 5000.0)
    if observations is None:
        return fallback
    crops = observations.get("crops", [])
    label, source = observations.get("label"), "authored"
    if label is None:
        sums = {}
        for crop in crops:
            if crop.get("valid", True):
                for name, value in crop.get("evidence", {}).items():
                    sums[canonical(name)] = sums.get(canonical(name), 0.0) + value
        sums = {m: s for m, s in sums.items() if s > 0}
        if not sums:
            return fallback
        label, source = max(sums, key=lambda m: sums[m]), "crop"
    branch, E_range, nu_range, rho = LABELS[label]
    E, nu, _, _ = moments(crops, label)
    value = 10.0 ** weighted(E) if E else E_default(label)
    ratio = weighted(nu) if nu else nu_default(label)
    return (
        source,
        label,
        branch,
        clip(value, *E_range),
        clip(clip(ratio, *nu_range), 0.05, 0.485),
        clip(rho, 100.0, 7800.0),
    )


def evidence(inventory, records, mask_confidences, seen):
    """All rows in inventory order, and the whole-object record."""
    whole = whole_object(records.get("whole_object"))
    seen.add("whole object: " + whole[0])
    by_key = {entry["key"]: entry for entry in records["rows"]}
    rows = []
    for row, confidence in zip(inventory["rows"], mask_confidences):
        key = row["object"] + "/" + row["part"]
        rows.append(evidence_of(row, by_key.get(key, {}), whole[1], confidence, seen))
    return rows, whole
