// The page of a preview: what the views show, and marking parts. What is saved is an inventory that make reads;
// preview-edit.js has materials and actions.
const data = JSON.parse(document.getElementById("data").textContent);
const views = [...document.querySelectorAll(".view")], editor = document.getElementById("editor");
const $ = (tag, properties = {}, ...children) => {
  const element = Object.assign(document.createElement(tag), properties);
  element.append(...children);
  return element;
};
const svg = (tag, attributes) => {
  const element = document.createElementNS("http://www.w3.org/2000/svg", tag);
  for (const [name, value] of Object.entries(attributes)) element.setAttribute(name, value);
  return element;
};

for (const button of document.querySelectorAll(".switch button")) {
  button.addEventListener("click", () => {
    for (const other of document.querySelectorAll(".switch button")) other.setAttribute("aria-pressed", String(other === button));
    document.body.className = document.body.className.replace(/show-\w+/g, "").trim();
    document.body.classList.add("show-" + button.dataset.show);
  });
}

// The coarse motion plays by itself, unless someone asked for stillness.
if (!matchMedia("(prefers-reduced-motion: reduce)").matches) document.querySelector(".motion video")?.play().catch(() => {});

// Parts: those of the inventory but its residual rows, and new ones. marks: outlines by view, in fractions of the picture.
const objects = data.inventory.objects;
const parts = data.inventory.rows.filter(row => !row.residual).map(row => ({row, object: row.object, name: row.name, label: row.expected_labels?.[0] ?? "", marks: {}, stated: {}}));
let chosen = -1, open = null;  // open: {view, points} of the outline that is being drawn
const colour = p => `rgb(${data.colors[p % data.colors.length].map(c => Math.round(255 * c))})`;
const statusLine = () => {
  const line = $("p", {className: "quiet"});
  line.setAttribute("role", "status");
  return line;
};
const status = statusLine();
const list = $("div");
const labelOptions = () => data.labels.map(({name}) => $("option", {value: name, textContent: name}));
const id = name => name.toLowerCase().normalize("NFKD").replace(/[^a-z0-9]+/g, "-").replace(/^-+|-+$/g, "").slice(0, 60) || "part";

function choose(p) {
  finish();
  chosen = chosen === p ? -1 : p;
  document.body.classList.toggle("marking", chosen >= 0);
  status.textContent = chosen >= 0 ? `Marking "${parts[chosen].name}": click around it in each view.` : "";
  show();
}
function show() {
  showMaterials();
  list.replaceChildren(...parts.map((part, p) => {
    const spot = $("i");
    spot.style.background = colour(p);
    const pick = $("button", {type: "button", className: "pick"}, spot);
    pick.setAttribute("aria-pressed", String(p === chosen));
    pick.setAttribute("aria-label", "Mark " + part.name);
    pick.addEventListener("click", () => choose(p));
    const name = $("input", {value: part.name, maxLength: 200});
    name.setAttribute("aria-label", "Name of part " + (p + 1));
    name.addEventListener("change", () => { part.name = name.value.trim() || part.name; show(); });
    const label = $("select", {}, $("option", {value: "", textContent: "material?"}), ...labelOptions());
    label.value = data.labels.some(l => l.name === part.label) ? part.label : "";
    label.setAttribute("aria-label", "Material of " + part.name);
    label.addEventListener("change", () => { part.label = label.value; showMaterials(); });
    const count = Object.values(part.marks).reduce((n, polygons) => n + polygons.length, 0);
    const clear = $("button", {type: "button", textContent: "Clear", disabled: count === 0});
    clear.setAttribute("aria-label", "Clear the outlines of " + part.name);
    clear.addEventListener("click", () => { part.marks = {}; show(); });
    return $("div", {className: "part"}, pick, name, label, $("span", {className: "count", textContent: count === 1 ? "1 outline" : count + " outlines"}), clear);
  }));
  for (const view of views) {
    const over = view.querySelector(".over"), box = over.viewBox.baseVal;
    const points = polygon => polygon.map(([x, y]) => `${x * box.width},${y * box.height}`).join(" ");
    const shapes = parts.flatMap((part, p) => (part.marks[view.dataset.view] ?? []).map(polygon =>
      svg("polygon", {points: points(polygon), stroke: colour(p), fill: colour(p), "fill-opacity": 0.3})));
    if (open?.view === view) shapes.push(svg("polyline", {points: points(open.points), stroke: colour(chosen)}));
    view.querySelector(".marks").replaceChildren(...shapes);
  }
}
function finish() {
  if (open && open.points.length >= 3 && chosen >= 0) {
    const place = open.view.dataset.view, round = v => Math.round(1e4 * Math.min(1, Math.max(0, v))) / 1e4;
    (parts[chosen].marks[place] ??= []).push(open.points.slice(0, 1024).map(point => point.map(round)));
  }
  open = null;
  show();
}
for (const view of views) {
  const over = view.querySelector(".over");
  let pressed = null;
  const place = event => {
    const box = over.getBoundingClientRect();
    return [(event.clientX - box.x) / box.width, (event.clientY - box.y) / box.height];
  };
  over.addEventListener("pointerdown", event => {
    if (chosen < 0) return;
    event.preventDefault();
    over.setPointerCapture(event.pointerId);
    pressed = {at: place(event), drawn: false};
    if (open && open.view !== view) finish();
    const [x, y] = pressed.at;
    if (open && open.points.length >= 3 && Math.hypot(open.points[0][0] - x, open.points[0][1] - y) < 0.02) { pressed = null; finish(); return; }
    open ??= {view, points: []};
    open.points.push(pressed.at);
    show();
  });
  // A stroke is an outline as well.
  over.addEventListener("pointermove", event => {
    if (!pressed || !open) return;
    const at = place(event), last = open.points[open.points.length - 1];
    if (Math.hypot(at[0] - last[0], at[1] - last[1]) < 0.008) return;
    pressed.drawn = true;
    open.points.push(at);
    show();
  });
  over.addEventListener("pointerup", () => {
    if (pressed?.drawn && open?.points.length >= 8) finish();
    pressed = null;
  });
  over.addEventListener("dblclick", event => { event.preventDefault(); finish(); });
}
document.addEventListener("keydown", event => {
  if (!open || /^(INPUT|SELECT)$/.test(event.target.tagName)) return;
  if (event.key === "Enter") finish();
  else if (event.key === "Escape") { open = null; show(); }
  else if (event.key === "Backspace") { open.points.pop(); if (!open.points.length) open = null; show(); }
  else return;
  event.preventDefault();
});

// The parts' ids, in their order, each once within its object.
function ids() {
  const taken = new Set();
  return parts.map(part => {
    let key = part.row ? part.row.part : id(part.name);
    for (let k = 2; taken.has(part.object + "/" + key); ++k) key = `${id(part.name)}-${k}`;
    taken.add(part.object + "/" + key);
    return key;
  });
}
// The inventory as it stands in the page. A part that was marked is found by its outlines alone.
function inventory() {
  const names = ids(), rows = [];
  for (const [p, part] of parts.entries()) {
    const row = part.row ? {...part.row} : {object: part.object, structural_role: "", physics_group: "", evidence_refs: []};
    Object.assign(row, {part: names[p], name: part.name});
    delete row.named_by;
    if (part.label) row.expected_labels = [part.label];
    if (Object.keys(part.marks).length) row.hints = {regions: part.marks};
    rows.push(row);
  }
  return {...data.inventory, rows};
}
// Under pm-report serve a record goes into the run's folder; a page that was opened as a file gives it as a download.
// kind: inventory, materials or plan; variable: of make, that takes the file.
async function save(kind, variable, record, said) {
  const text = JSON.stringify(record, null, 2) + "\n";
  if (location.protocol === "http:") {
    try {
      const reply = await fetch(kind, {method: "POST", headers: {"Content-Type": "application/json"}, body: text});
      said.textContent = await reply.text();
    } catch {
      said.textContent = "Not saved: pm-report serve does not answer.";
    }
    return;
  }
  const name = `marked-${kind}.json`;
  const link = $("a", {href: URL.createObjectURL(new Blob([text], {type: "application/json"})), download: name});
  link.click();
  setTimeout(() => URL.revokeObjectURL(link.href), 10000);
  said.textContent = `Saved as ${name}. Give it to make: ${variable}=${name}, with the other variables of this run.`;
}
const add = $("button", {type: "button", textContent: "New part"}), keep = $("button", {type: "button", className: "act", id: "save", textContent: "Save the inventory"});
add.addEventListener("click", () => {
  parts.push({row: null, object: objects[0].id, name: `part ${parts.length + 1}`, label: "", marks: {}, stated: {}});
  choose(parts.length - 1);
  list.lastElementChild.querySelector("input").select();
});
keep.addEventListener("click", () => { finish(); save("inventory", "INVENTORY", inventory(), status); });
editor.append(list, $("div", {className: "row"}, add, keep), status);
