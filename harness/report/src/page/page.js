"use strict";
// Opens the entry that the address names, also after a click on a mark of a timeline.
function openNamed() {
  const entry = document.getElementById(decodeURIComponent(location.hash.slice(1)));
  if (entry && entry.tagName === "DETAILS") {
    entry.open = true;
    entry.scrollIntoView({ block: "center" });
  }
}
// A long page is packed: base64 of raw deflate.
async function unpack(packed) {
  const octets = Uint8Array.from(atob(packed.textContent), (letter) => letter.charCodeAt(0));
  const stream = new Blob([octets]).stream().pipeThrough(new DecompressionStream("deflate-raw"));
  document.querySelector("main").innerHTML = await new Response(stream).text();
}
// Buttons and keys zoom and move a timeline, dragging moves it, the wheel zooms it at the pointer while Ctrl is held.
function zoomable(figure) {
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
  const zoom = (factor, part) => {
    const at = left + part * visible;
    visible = Math.min(width, Math.max(0.5, visible * factor));
    left = at - part * visible;
    show();
  };
  const move = (part) => { left += part * visible; show(); };
  const reset = () => { left = 0; visible = width; show(); };
  const actions = [
    ["+", "zoom in", ["+", "="], () => zoom(0.5, 0.5)],
    ["\u2212", "zoom out", ["-"], () => zoom(2, 0.5)],
    ["\u25c2", "earlier", ["ArrowLeft"], () => move(-0.25)],
    ["\u25b8", "later", ["ArrowRight"], () => move(0.25)],
    ["all", "show all", ["0", "Home"], reset],
  ];
  const bar = document.createElement("div");
  bar.className = "zoom";
  for (const [text, title, keys, act] of actions) {
    const button = document.createElement("button");
    Object.assign(button, { type: "button", textContent: text, title: `${title} (key ${keys[0]})`, onclick: act });
    button.setAttribute("aria-label", title);
    bar.append(button);
  }
  figure.querySelector("figcaption").append(bar);
  figure.tabIndex = 0;
  figure.addEventListener("keydown", (event) => {
    const action = event.ctrlKey || event.altKey || event.metaKey ? null : actions.find(([, , keys]) => keys.includes(event.key));
    if (action) {
      event.preventDefault();
      action[3]();
    }
  });
  for (const svg of all) {
    svg.addEventListener("wheel", (event) => {
      if (!event.ctrlKey) return;
      event.preventDefault();
      zoom(event.deltaY > 0 ? 1.25 : 0.8, event.offsetX / svg.clientWidth);
    }, { passive: false });
    svg.addEventListener("pointerdown", (event) => { drag = { x: event.clientX, left }; });
    svg.addEventListener("pointermove", (event) => {
      if (drag && event.buttons) {
        left = drag.left - (event.clientX - drag.x) / svg.clientWidth * visible;
        show();
      }
    });
    svg.addEventListener("dblclick", reset);
  }
  show();
}
async function start() {
  const packed = document.getElementById("packed");
  if (packed) await unpack(packed);
  document.querySelectorAll(".timeline").forEach(zoomable);
  addEventListener("hashchange", openNamed);
  openNamed();
  document.body.dataset.ready = String(document.querySelectorAll(".entry").length);
}
start();
