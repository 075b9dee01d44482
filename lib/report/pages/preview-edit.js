// Materials and actions on the page of a preview: what a person states of them is saved as records that make reads.

// A number as it was typed; NaN: none.
const numberOf = text => (/^[-+]?(\d+\.?\d*|\.\d+)(e[-+]?\d+)?$/i.test(text.trim()) ? Number(text) : NaN);
const short = value => {
  const text = Number(value.toPrecision(4)).toString();
  return text.length > 7 ? value.toExponential(3).replace(/\.?0+e/, "e").replace("e+", "e") : text;
};
// good: whether a number may stand here.
function numberInput(label, value, placeholder, good, changed) {
  const input = $("input", {value, placeholder, inputMode: "decimal", autocomplete: "off", maxLength: 40});
  input.setAttribute("aria-label", label);
  input.addEventListener("change", () => {
    const number = numberOf(input.value), empty = input.value.trim() === "" && placeholder !== "";
    const wrong = !empty && !(Number.isFinite(number) && good(number));
    input.setAttribute("aria-invalid", String(wrong));
    changed(empty ? undefined : number);
  });
  return input;
}
const wrongIn = element => [...element.querySelectorAll("[aria-invalid=true]")].map(input => input.getAttribute("aria-label"));
const complaint = wrong => `Not saved: ${wrong.join(", ")} cannot be that.`;

// What is stated of parts. An empty field stays as it is assumed, or as the label has it where another one is chosen.
const materials = document.getElementById("material-editor"), materialRows = $("div", {className: "rows"}), materialSaid = statusLine();
const kMaterial = [
  {field: "E", name: "E", unit: "Pa", good: v => v > 0 && v <= 1e15},
  {field: "nu", name: "ν", unit: "", good: v => v >= 0 && v < 0.5},
  {field: "rho", name: "ρ", unit: "kg/m³", good: v => v > 0 && v <= 1e9},
];
function showMaterials() {
  materialRows.replaceChildren(...parts.map(part => {
    const assumed = part.row ? data.materials[part.object + "/" + part.row.part] : null;
    const label = $("select", {}, $("option", {value: "", textContent: assumed ? `${assumed.label} (assumed)` : "as it will be found"}), ...labelOptions());
    label.value = part.stated.label ?? "";
    label.setAttribute("aria-label", "Material label of " + part.name);
    label.addEventListener("change", () => {
      if (label.value) part.stated.label = label.value;
      else delete part.stated.label;
      showMaterials();
    });
    const standard = part.stated.label ? data.labels.find(l => l.name === part.stated.label) : assumed;
    const numbers = kMaterial.map(({field, name, unit, good}) => {
      const given = part.stated[field];
      const input = numberInput(`${name} of ${part.name}`, given === undefined ? "" : String(given), standard ? short(standard[field]) : "–", good, value => {
        if (value === undefined) delete part.stated[field];
        else part.stated[field] = value;
      });
      return $("label", {}, $("span", {textContent: unit ? `${name} (${unit})` : name}), input);
    });
    return $("div", {className: "stated"}, $("b", {textContent: part.name}), label, ...numbers);
  }));
}
const keepMaterials = $("button", {type: "button", className: "act", id: "save-materials", textContent: "Save the materials"});
keepMaterials.addEventListener("click", () => {
  const wrong = wrongIn(materials), names = ids();
  const rows = parts.map((part, p) => ({key: part.object + "/" + names[p], stated: part.stated})).filter(row => Object.keys(row.stated).length);
  if (wrong.length) materialSaid.textContent = complaint(wrong);
  else if (!rows.length) materialSaid.textContent = "Nothing is stated yet.";
  else save("materials", "AUTHORED", {schema: "physmas/material_records/1", rows}, materialSaid);
});
materials.append(materialRows, $("div", {className: "row"}, keepMaterials), materialSaid);

// Direction, strength and time of each action.
const actions = document.getElementById("action-editor");
if (actions) {
  const said = statusLine(), plan = data.plan;
  const rows = plan.actions.map((action, k) => {
    const of = `action ${k + 1}`, about = data.actions[k];
    const field = (text, input) => $("label", {}, $("span", {textContent: text}), input);
    const axes = ["x", "y", "z"].map((axis, a) => field(axis, numberInput(`Direction ${axis} of ${of}`, short(action.direction[a]), "", () => true, v => { action.direction[a] = v; })));
    const strength = about.has_strength ? [field(about.unit ? `strength (${about.unit.trim()})` : "to this part of its size",
      numberInput(`Strength of ${of}`, short(action.magnitude), "", v => v >= 0 && v <= about.most, v => { action.magnitude = v; }))] : [];
    const time = [["start", "from (s)"], ["end", "to (s)"]].map(([name, text]) =>
      field(text, numberInput(`${name === "start" ? "Start" : "End"} of ${of}`, short(action[name]), "", v => v >= 0, v => { action[name] = v; })));
    return $("div", {className: "stated"}, $("b", {textContent: `${k + 1}. ${about.words}`}), ...axes, ...strength, ...time);
  });
  const keepActions = $("button", {type: "button", className: "act", id: "save-plan", textContent: "Save the actions"});
  keepActions.addEventListener("click", () => {
    const wrong = wrongIn(actions);
    const none = plan.actions.findIndex(({direction}) => !(Math.hypot(...direction) > 0)), late = plan.actions.findIndex(a => a.end < a.start);
    if (wrong.length) said.textContent = complaint(wrong);
    else if (none >= 0) said.textContent = `Not saved: action ${none + 1} has no direction.`;
    else if (late >= 0) said.textContent = `Not saved: action ${late + 1} ends before it begins.`;
    else save("plan", "PLAN", {...plan, actions: plan.actions.map(a => ({...a, direction: a.direction.map(v => v / Math.hypot(...a.direction))}))}, said);
  });
  actions.append(...rows, $("div", {className: "row"}, keepActions), said);
}
show();
