// The page of a run: videos that play together, stills that lead to their time, and the viewer when it is looked at.
const cards = [...document.querySelectorAll(".card")];
for (const card of cards) {
  const video = card.querySelector("video");
  for (const still of card.querySelectorAll(".stills button")) {
    still.addEventListener("click", () => { video.pause(); video.currentTime = Number(still.dataset.time); });
  }
}
const all = document.getElementById("play-all");
all?.addEventListener("click", () => {
  const videos = cards.map(card => card.querySelector("video")).filter(video => video);
  const playing = videos.some(video => !video.paused);
  for (const video of videos) {
    if (playing) { video.pause(); continue; }
    video.currentTime = 0;
    video.play().catch(() => {});
  }
  all.textContent = playing ? "Play all together" : "Pause all";
});
let viewer = null;
const place = document.getElementById("viewer");
if (place) {
  const watcher = new IntersectionObserver(entries => {
    if (!entries.some(entry => entry.isIntersecting)) return;
    watcher.disconnect();
    const header = JSON.parse(document.getElementById("header").textContent);
    viewer = mountViewer(place, header, document.getElementById("stream").textContent.trim());
  }, {rootMargin: "300px"});
  watcher.observe(place);
}
