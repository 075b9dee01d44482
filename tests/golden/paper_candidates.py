"""Candidates and screening recomputed from the paper's text: "Candidate Construction and Repair Transforms" and
"Validity Gate, Ranking, and Tie Rules". See paper.py."""

import math

from paper import E_default, LABELS, RIGID, clip, has, nu_default, text

INITIAL = [
    "posterior", "target-impact", "hard-support-bonded", "support-stiff", "solver-compatible", "rigid-support",
    "soft", "stiff", "uncertainty-sweep", "alternative-material",
]
REPAIRS = [
    "support-stiffness", "rigid-support", "elastic-cohesion", "higher-cohesion", "solver-stability", "role-balanced",
]
KAPPA = {0.15: -1.04, 0.25: -0.67, 0.50: 0.0, 0.75: 0.67, 0.85: 1.04}
SOFT_BRANCHES = ("Foam", "Plasticine", "Jelly")

S_TOKENS = [
    "plate", "dish", "tray", "stand", "support", "holder", "structural", "rigid", "load bearing", "load-bearing",
    "frame", "shell", "blade", "head", "tip", "impact part",
]
S_SOFT = [
    "soft", "deformable", "compressible", "cushion", "foam", "sponge", "flesh", "fruit", "food", "filling", "cream",
    "frosting", "icing",
]
C_TOKENS = [
    "body", "base", "core", "main", "bulk", "filling", "coating", "layer", "cream", "frosting", "icing", "fruit",
    "organic", "soft", "deformable", "foam", "sponge", "rubber", "gel", "cloth", "fabric", "leather", "pad",
]


def three_fields(row):
    return text(row["name"], row.get("physics_group", ""), row.get("structural_role", ""))


def S(row, label):
    if has(three_fields(row), S_TOKENS):
        return True
    return label in RIGID and not has(three_fields(row), S_SOFT)


def C(row, label):
    if S(row, label):
        return False
    where = text(row["name"], row.get("physics_group", ""), row.get("structural_role", ""), label)
    return has(where, C_TOKENS) or (LABELS[label][0] in SOFT_BRANCHES and label not in RIGID)


def omega(row, label):
    if S(row, label):
        return 1.6
    for weight, tokens in [
        (1.45, ["candle", "stem", "stick", "handle"]),
        (1.25, ["fruit", "strawberry", "berry", "decoration"]),
        (1.05, ["cream", "frosting", "icing"]),
    ]:
        if has(three_fields(row), tokens):
            return weight
    return 1.0


class Scene:
    """Active rows with their evidence and construction predicates."""

    def __init__(self, inventory, evidence, whole, plan, counts, run):
        self.run, self.whole = run, whole
        self.active = []
        targets = set()
        for action in plan["actions"]:
            if action["impact"] and action["role"] == "target":
                for row in inventory["rows"]:
                    if action["target"] in (row["object"], row["object"] + "/" + row["part"]):
                        targets.add(row["object"] + "/" + row["part"])
        for row, psi, count in zip(inventory["rows"], evidence, counts):
            residual = row.get("residual", False)
            if residual and count == 0:
                continue
            key = row["object"] + "/" + row["part"]
            self.active.append(
                {
                    "key": key,
                    "row": row,
                    "psi": psi,
                    "residual": residual,
                    "S": S(row, psi["label"]),
                    "C": C(row, psi["label"]),
                    "omega": omega(row, psi["label"]),
                    "target": key in targets,
                }
            )
        self.objects = {a["row"]["object"] for a in self.active}
        self.gamma = sum(a["psi"]["gamma"] for a in self.active) / len(self.active)


def ordinary(label, E, nu):
    """The ordinary solver ranges: nu in [0.05, 0.45], rho in [300, 3000]."""
    branch, _, _, rho = LABELS[label]
    return {"branch": branch, "E": E, "nu": clip(nu, 0.05, 0.45), "rho": clip(rho, 300.0, 3000.0), "label": label}


def at(a, xi_E, xi_nu):
    """Eq. quantile."""
    psi = a["psi"]
    _, E_range, nu_range, _ = LABELS[psi["label"]]
    return ordinary(
        psi["label"],
        clip(10.0 ** (psi["e"] + KAPPA[xi_E] * psi["sigma_e"]), *E_range),
        clip(psi["nu"] + KAPPA[xi_nu] * psi["sigma_nu"], *nu_range),
    )


def candidate(scene, rows, projection=None, retention=None):
    return {
        "rows": {a["key"]: r for a, r in zip(scene.active, rows)},
        "projection": projection or {},
        "retention": retention or [],
    }


def transform(scene, name, seen):
    """One row of Table "candidatetransforms", or None when it is not emitted."""
    g_branch, E_g, nu_g, rho_g = scene.whole[2:]
    active = scene.active
    supported = any(a["S"] for a in active)
    both = supported and any(not a["S"] and a["C"] for a in active)
    median = [at(a, 0.50, 0.50) for a in active]
    if name == "posterior":
        return candidate(scene, median)
    if name == "soft":
        return candidate(scene, [at(a, 0.25, 0.75) for a in active])
    if name == "stiff":
        return candidate(scene, [at(a, 0.75, 0.50) for a in active])
    if name == "uncertainty-sweep":
        semantic = [a for a in active if not a["residual"]]
        if not semantic:
            return None
        weakest = min(semantic, key=lambda a: a["psi"]["gamma"])  # the first of equals
        return candidate(scene, [at(a, 0.15 if a is weakest else 0.50, 0.75) for a in active])
    if name == "alternative-material":
        chosen, best = None, -1.0
        for a in active:
            second, p = list(a["psi"]["P"].items())[1]
            if p >= 0.12 and E_default(second) <= max(10 * 10.0 ** a["psi"]["e"], 1e7) and p > best:
                chosen, best = a, p
        if chosen is None:
            return None
        second = list(chosen["psi"]["P"])[1]
        seen.add("alternative: " + ("another label" if second != chosen["psi"]["label"] else "the stored label itself"))
        return candidate(
            scene,
            [
                (
                    ordinary(second, E_default(second), nu_default(second))
                    if a is chosen and second != a["psi"]["label"]
                    else m
                )
                for a, m in zip(active, median)
            ],
        )
    if name == "target-impact":
        if not any(a["target"] and not a["residual"] and not a["S"] and a["C"] for a in active):
            return None
        rows = []
        for a, r in zip(active, median):
            r = dict(r)
            if a["target"] and a["S"]:
                r.update(branch="Metal", E=1e7, nu=clip(r["nu"], 0.05, 0.35), rho=max(r["rho"], 1000.0))
                seen.add("target-impact: S row")
            elif a["target"] and a["C"] and not a["residual"]:
                r.update(
                    branch=r["branch"] if r["branch"] in SOFT_BRANCHES else "Foam",
                    E=clip(r["E"], 2e4, 7.5e4),
                    nu=clip(r["nu"], 0.2, 0.4),
                    rho=min(450.0, max(300.0, r["rho"])),
                )
                seen.add("target-impact: C row")
            elif a["target"]:
                seen.add("target-impact: residual row" if a["residual"] else "target-impact: neither")
            rows.append(r)
        return candidate(scene, rows)
    if name == "hard-support-bonded":
        if not both:
            return None
        rows, supports = [], [a["key"] for a in active if a["S"]]
        for a, r in zip(active, median):
            r = dict(r)
            if a["S"]:
                r.update(branch="Metal", E=1e7, nu=0.35, rho=2500.0)
            else:
                r.update(branch="Plasticine", E=max(r["E"], a["omega"] * E_g), nu=clip(nu_g, 0.2, 0.485), rho=rho_g)
            rows.append(r)
        several = len(scene.objects) > 1
        seen.add("bonded: " + ("several objects" if several else "one object"))
        return candidate(scene, rows, {k: 0.85 for k in supports}, [] if several else supports)
    if name == "support-stiff":
        if not supported:
            return None
        return candidate(
            scene,
            [
                dict(r, branch="Metal", E=1e7, nu=min(r["nu"], 0.35), rho=max(r["rho"], 1000.0)) if a["S"] else r
                for a, r in zip(active, median)
            ],
        )
    if name == "solver-compatible":
        if not both:
            return None
        branch = g_branch if g_branch in ("Plasticine", "Jelly", "Foam") else "Plasticine"
        return candidate(
            scene,
            [
                dict(
                    r,
                    branch=branch,
                    E=clip(a["omega"] * E_g, 0.85 * E_g, 1.7 * E_g),
                    nu=clip(nu_g, 0.2, 0.485),
                    rho=rho_g,
                )
                for a, r in zip(active, median)
            ],
        )
    if name == "rigid-support":
        if not supported:
            return None
        rows = [at(a, 0.25, 0.75) for a in active]
        return candidate(
            scene,
            [dict(r, E=1e7) if a["S"] else r for a, r in zip(active, rows)],
            {a["key"]: 1.0 for a in active if a["S"]},
        )
    raise KeyError(name)


def equal(a, b):
    return a["rows"] == b["rows"] and a["projection"] == b["projection"] and a["retention"] == b["retention"]


def step(scene, made):
    """Eqs. supp-wavespeed and supp-adaptivedt with the caps: (target, substeps, dt)."""
    time = scene.run["time"]

    def speed(E, nu, rho):
        return math.sqrt((E * nu / ((1 + nu) * (1 - 2 * nu)) + 2 * (E / (2 * (1 + nu)))) / rho)

    c = max([speed(*scene.whole[3:])] + [speed(r["E"], r["nu"], r["rho"]) for r in made["rows"].values()])
    ref = speed(5e6, 0.35, 2500)
    dt0, frame = time["substep_dt"], time["frame_dt"]
    target = dt0 if c <= 0.7 * ref else 0.7 * dt0 * ref / c
    n = math.ceil(frame / target * (1 - 1e-9))
    n = min(n, math.floor(frame / time["min_substep_dt"] * (1 + 1e-9)), time["max_substeps"])
    n = max(n, 1)
    return target, n, frame / n


def initial(scene, seen):
    """Round 0: id -> candidate, the first retained ones in the fixed order."""
    made = {}
    for name in INITIAL:
        one = transform(scene, name, seen)
        if one is None:
            seen.add(name + ": not applicable")
        elif any(equal(one, other) for other in made.values()):
            seen.add(name + ": equals an earlier one")
        elif len(made) == scene.run["screening"]["initial"]:
            seen.add(name + ": not retained")
        else:
            seen.add(name + ": emitted")
            one.update(transform=name, base=scene.gamma, parent=None)
            made[name] = one
    return made


def S_hat(row, r):
    return (
        has(
            text(row["name"]),
            ["plate", "dish", "tray", "bowl", "base support", "support", "stand", "holder", "case", "shell", "frame"],
        )
        or r["label"] in RIGID
    )


def C_hat(row, r):
    if S_hat(row, r) or r["branch"] in ("Sand", "Snow"):
        return False
    where = text(row["name"], row.get("physics_group", ""), row.get("structural_role", ""), r["label"])
    return has(
        where,
        [
            "body",
            "base",
            "core",
            "filling",
            "cream",
            "frosting",
            "icing",
            "soft",
            "cushion",
            "pad",
            "foam",
            "sponge",
            "rubber",
            "gel",
            "fruit",
            "food",
        ],
    ) or (r["branch"] in SOFT_BRANCHES and r["label"] not in RIGID)


def repair(scene, name, base, seen):
    """A repair row of the table, on the base's current rows."""
    rows, projection = {}, dict(base["projection"])
    for a in scene.active:
        r = dict(base["rows"][a["key"]])
        support, cohesive = S_hat(a["row"], r), C_hat(a["row"], r)
        elastic = dict(branch="Jelly", E=max(r["E"], 5e5), nu=clip(r["nu"], 0.2, 0.42), rho=max(r["rho"], 500.0))
        if name == "solver-stability":
            r.update(nu=min(r["nu"], 0.40), rho=max(r["rho"], 300.0))
        elif support:
            r.update(branch="Metal", E=1e7, nu=min(r["nu"], 0.35), rho=max(r["rho"], 1000.0))
            if name == "rigid-support":
                projection[a["key"]] = 1.0
            seen.add("repair " + name + ": support row")
        elif cohesive and name == "elastic-cohesion":
            r.update(elastic)
            seen.add("repair elastic-cohesion: cohesive row")
        elif cohesive and name == "higher-cohesion":
            r.update(E=max(r["E"], 5e5), rho=max(r["rho"], 500.0))
            seen.add("repair higher-cohesion: cohesive row")
        elif cohesive and name == "role-balanced" and r["branch"] in ("Foam", "Plasticine"):
            r.update(elastic)
            seen.add("repair role-balanced: cohesive row")
        rows[a["key"]] = r
    return {
        "rows": rows,
        "projection": projection,
        "retention": list(base["retention"]),
        "transform": name,
        "base": base["base"],
        "parent": base["id"],
    }


def repairs(scene, base, routes, known, seen):
    """The repairs of a round: the routed ones that are unseen, at most as many as the run allows."""
    made = {}
    for name in REPAIRS:
        if name not in routes:
            continue
        one = repair(scene, name, base, seen)
        id_ = base["id"] + "-" + name
        if id_ in known or any(equal(one, other) for other in list(known.values()) + list(made.values())):
            seen.add("repair " + name + ": seen before")
        elif len(made) == scene.run["screening"]["repairs"]:
            seen.add("repair " + name + ": above the budget")
        else:
            seen.add("repair " + name + ": emitted")
            made[id_] = one
    return made


def score(scene, made, execution, render, seen):
    """Features, penalty, Q and gates of one executed candidate."""
    frames = scene.run["time"]["frames"]
    rows = [(a, made["rows"][a["key"]]) for a in scene.active]
    n = len(rows)
    by_frame = {f["frame"]: f["box"] for f in render["frames"]}
    first, last = by_frame.get(0), by_frame.get(frames - 1)
    if not render["video"]:
        video = -0.15
        seen.add("video: missing")
    elif render["file_size"] < 4096:
        video = -0.20
        seen.add("video: small")
    else:
        video = 0.20
    spread = flat = True
    if first and last:
        video += 0.12
        growth = (last["w"] * last["h"]) / (first["w"] * first["h"])
        height, width = last["h"] / first["h"], last["w"] / first["w"]
        spread, flat = growth <= 2.0, not (height < 0.45 and width > 1.25)
        if growth > 2.0:
            video -= 0.25
        elif growth > 1.45:
            video -= 0.10
            seen.add("video: grows above 1.45")
        if not flat:
            video -= 0.22
        if last["dark"] > 0.18:
            video -= 0.08
            seen.add("video: dark")
    else:
        seen.add("video: no endpoints")

    def role(a, r):
        name = text(a["row"]["name"])
        if has(name, ["head", "blade", "tip", "plate", "support", "stand", "tray", "dish", "shell", "frame"]):
            return 1.0 if r["E"] >= 1e6 and r["branch"] == "Metal" else 0.35
        if has(name, ["rubber", "sole", "tire", "wheel", "foam", "cushion"]):
            return 1.0 if r["E"] <= 1e8 else 0.5
        return 0.7

    def solver(a, r):
        if r["label"] == "Plasticine" and has(text(a["row"]["name"]), ["clay", "putty", "plasticine", "dough"]):
            seen.add("solver: clay")
            return 1.0 if r["branch"] == "Plasticine" else 0.7
        return 1.0 if r["branch"] == "Jelly" else 0.55 if r["branch"] in ("Foam", "Plasticine") else 0.7

    cohesive = [solver(a, r) for a, r in rows if C_hat(a["row"], r)]
    features = [
        video,
        sum(a["psi"]["gamma"] for a, _ in rows) / n,
        len({r["label"] for _, r in rows}) / n,
        sum(role(a, r) for a, r in rows) / n,
        made["base"],
        sum(0.35 if r["rho"] < 250 else 0.55 if r["rho"] > 5000 else 1.0 for _, r in rows) / n,
        sum(cohesive) / len(cohesive) if cohesive else 0.7,
    ]
    penalty = min(0.12, 0.025 * len(made["projection"]) + 0.035 * len(made["retention"]))
    Q = sum(w * f for w, f in zip([1, 0.27, 0.10, 0.25, 0.15, 0.08, 0.15], features)) - penalty
    supports = [r["E"] for a, r in rows if S_hat(a["row"], r)]
    gates = {
        "plan": scene.resolved,
        "process": execution["exit"] == 0 and execution["signal"] == 0,
        "numerical": not execution["tokens"],
        "spread": spread,
        "flattening": flat,
        "support": made["transform"] == "solver-compatible" or all(E >= 1e7 for E in supports),
    }
    for name, passed in gates.items():
        seen.add("gate {}: {}".format(name, "passed" if passed else "failed"))
    return {
        "features": features,
        "penalty": penalty,
        "score": Q,
        "gates": gates,
        "admitted": all(gates.values()) and Q >= scene.run["screening"]["tau"],
    }


def decide(scene, screened, round_, seen):
    """Ranking, decision, base and routes. screened: id -> score(), in order of first appearance."""
    ranked = sorted(screened, key=lambda id_: -screened[id_]["score"])
    admitted = [id_ for id_ in ranked if screened[id_]["admitted"]]
    if admitted:
        return {"ranked": ranked, "decision": "accept", "accepted": admitted[0], "base": None, "routes": []}
    if round_ + 1 >= scene.run["screening"]["rounds"]:
        return {"ranked": ranked, "decision": "fail", "accepted": None, "base": None, "routes": []}
    gates = screened[ranked[0]]["gates"]
    routes = []
    if not gates["support"]:
        routes += REPAIRS[0:2]
    if not gates["spread"] or not gates["flattening"]:
        routes += REPAIRS[2:4]
    if not gates["process"] or not gates["numerical"]:
        routes += [REPAIRS[4]]
    if not routes and screened[ranked[0]]["score"] < scene.run["screening"]["tau"]:
        routes = [REPAIRS[5]]
    for route in routes:
        seen.add("route: " + route)
    return {"ranked": ranked, "decision": "repair", "accepted": None, "base": ranked[0], "routes": routes}
