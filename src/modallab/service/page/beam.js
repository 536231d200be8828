/** The beam from the side, with its clamp and its points. */

import { put, svg } from "./dom.js";

const WIDTH = 640;
const LEFT = 36;
const RIGHT = 20;
const MIDDLE = 46;

/** A drawing that says which point is struck next, and how many hits each has. */
export class BeamDrawing {
  constructor(description) {
    const length = description.beam?.length_m ?? Math.max(0.1, ...description.points.map(({ x_m: x }) => x));
    this.x = (place) => LEFT + (place / length) * (WIDTH - LEFT - RIGHT);
    this.points = description.points;
    this.sensors = new Set(description.channels.filter(({ quantity }) => quantity !== "force").map(({ point }) => point));
    this.marks = svg("g");
    this.element = svg("svg", { viewBox: `0 0 ${WIDTH} 92`, class: "beam", role: "img" }, svg("title", {}, "The beam and its points"),
      svg("path", { class: "clamp", d: `M${LEFT} 14v62m0 -62l-12 12m12 4l-12 12m12 4l-12 12m12 4l-12 12` }),
      svg("rect", { class: "body", x: LEFT, y: MIDDLE - 5, width: WIDTH - LEFT - RIGHT, height: 10 }), this.marks);
    this.show(null, {}, 0);
  }

  /** `next`: the point to strike; `counts`: good hits by point; `of`: how many are asked for. */
  show(next, counts, of) {
    this.element.firstChild.textContent = next === null ? "The beam and its points" : `The beam: strike point ${next} next`;
    put(this.marks, this.points.map(({ id, x_m: place }) => {
      const x = this.x(place);
      const done = of > 0 && (counts[id] ?? 0) >= of;
      return [
        svg("circle", { class: `point${id === next ? " next" : done ? " done" : ""}`, cx: x, cy: MIDDLE, r: id === next ? 11 : 6 }),
        svg("text", { x, y: 84, class: id === next ? "next" : "" }, String(id)),
        id === next && svg("path", { class: "arrow", d: `M${x} 30v-24m-6 14l6 10l6 -10` }),
        counts[id] !== undefined && id !== next && svg("text", { x, y: 30, class: "count" }, `${counts[id]}/${of}`),
      ];
    }));
  }
}
