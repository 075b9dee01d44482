const header = JSON.parse(document.getElementById("header").textContent);
header.whole = true;
const viewer = mountViewer(document.querySelector("main"), header, document.getElementById("stream").textContent.trim());
document.querySelector(".v-bar")?.append(Object.assign(document.createElement("p"), {className: "v-about", textContent: header.about, title: header.about}));
