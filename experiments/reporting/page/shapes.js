"use strict";
const WIDTH = 640, HEIGHT = 480;  // of the wrist camera's picture, px
let clips = 0;

// The smallest and largest coordinates of outlines: "M x,y l dx,dy … z" rings.
function extent(paths) {
  let box = [Infinity, Infinity, -Infinity, -Infinity];
  for (const ring of paths.join("").split("M").slice(1)) {
    const numbers = ring.match(/-?\d+/g).map(Number);
    let x = 0, y = 0;
    for (let place = 0; place + 1 < numbers.length; place += 2) {
      x += numbers[place];
      y += numbers[place + 1];
      box = [Math.min(box[0], x), Math.min(box[1], y), Math.max(box[2], x), Math.max(box[3], y)];
    }
  }
  return box;
}

// The part of the picture to show: 4:3, around the outlines, within the picture.
function crop(item) {
  const [left, top, right, bottom] = extent([item.mask || "", item.model || "", item.truth || ""]);
  if (left > right) return [0, 0, WIDTH, HEIGHT];
  const width = Math.min(WIDTH, Math.max(1.35 * (right - left), 1.35 * (bottom - top) * 4 / 3, 120));
  const height = width * 3 / 4;
  const x = Math.min(Math.max(0, (left + right - width) / 2), WIDTH - width);
  const y = Math.min(Math.max(0, (top + bottom - height) / 2), HEIGHT - height);
  return [x, y, width, height].map((value) => value.toFixed(1));
}

const outlined = (path, kind) => (path ? make("path", { d: path, class: kind, "fill-rule": "evenodd" }) : null);

function drawing(item, box, label, layers) {
  const svg = make("svg", { viewBox: box.join(" "), role: "img", "aria-label": label });
  svg.append(...layers.filter((layer) => layer !== null));
  return svg;
}

const pictured = (item) => (item.wrist ? make("image", { href: item.wrist, width: WIDTH, height: HEIGHT }) : null);

// Mask and model over each other: green is what both cover, the paper's c is its share of all that is coloured.
function overlap(item, box, label) {
  const id = `clip-${clips++}`;
  const clip = make("clipPath", { id }, make("path", { d: item.mask, "clip-rule": "evenodd" }));
  const both = make("path", { d: item.model, class: "overlap", "fill-rule": "evenodd", "clip-path": `url(#${id})` });
  return drawing(item, box, label, [clip, outlined(item.mask, "mask"), outlined(item.model, "model filled"), both]);
}

const thumbnail = (item) => (item.mask === undefined ? null : overlap(item, crop(item), "mask and model"));
