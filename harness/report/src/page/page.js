"use strict";
// Opens the entry that the address names, also after a click on a mark of a timeline.
function openNamed() {
  const entry = document.getElementById(decodeURIComponent(location.hash.slice(1)));
  if (entry && entry.tagName === "DETAILS") {
    entry.open = true;
    entry.scrollIntoView({ block: "center" });
  }
}
addEventListener("hashchange", openNamed);
openNamed();
// The wheel zooms a timeline at the pointer, dragging moves it, a double click resets it.
for (const figure of document.querySelectorAll(".timeline")) {
  const width = 10000, all = [...figure.querySelectorAll("svg")];
  const from = Number(figure.dataset.from), span = Number(figure.dataset.to) - from;
  const ticks = figure.querySelector(".ticks");
  let left = 0, visible = width, drag = null;
  const show = () => {
    left = Math.min(Math.max(left, 0), width - visible);
    for (const svg of all) svg.setAttribute("viewBox", `${left} 0 ${visible} 100`);
    ticks.replaceChildren(...[0, 0.25, 0.5, 0.75, 1].map((part) => {
      const tick = document.createElement("span");
      tick.textContent = `${(from + (left + part * visible) / width * span).toFixed(6)} s`;
      return tick;
    }));
  };
  for (const svg of all) {
    svg.addEventListener("wheel", (event) => {
      event.preventDefault();
      const part = event.offsetX / svg.clientWidth, at = left + part * visible;
      visible = Math.min(width, Math.max(0.5, visible * (event.deltaY > 0 ? 1.25 : 0.8)));
      left = at - part * visible;
      show();
    }, { passive: false });
    svg.addEventListener("pointerdown", (event) => { drag = { x: event.clientX, left }; });
    svg.addEventListener("pointermove", (event) => {
      if (drag && event.buttons) {
        left = drag.left - (event.clientX - drag.x) / svg.clientWidth * visible;
        show();
      }
    });
    svg.addEventListener("dblclick", () => { left = 0; visible = width; show(); });
  }
  show();
}
document.body.dataset.ready = String(document.querySelectorAll(".entry").length);
