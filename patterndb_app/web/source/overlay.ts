/** What lies over the canvas: a handle at every corner, a count at every side. */

import { type CountField, makeCountField } from "./fields.ts";
import { make } from "./dom.ts";
import type { Stage } from "./scene.ts";
import type { Sketch } from "./sketch.ts";
import { distance, dot, interpolateAlong, type Point, subtract } from "./vectors.ts";

export interface OverlayActions {
  count(side: number, value: number): void;
  /** A corner is dragged or nudged; `done` when it is let go. */
  move(corner: number, to: Point, done: boolean): void;
  toggle(corner: number): void;
}

/** Pixels from a side to its count. */
const AWAY = 24;

/** Pixels that an arrow key moves a corner. */
const NUDGE = 6;

export class Overlay {
  private fields: CountField[] = [];
  private handles: HTMLButtonElement[] = [];

  constructor(
    private readonly element: HTMLElement,
    private readonly stage: Stage,
    private readonly sketch: Sketch,
    private readonly actions: OverlayActions,
  ) {
    stage.onDrawn(() => this.place());
  }

  /** Makes as many handles and fields as there are corners and sides. */
  rebuild(): void {
    this.element.replaceChildren();
    this.fields = [];
    this.handles = [];
    if (!this.sketch.closed) return;
    this.sketch.counts.forEach((count, side) => {
      const field = makeCountField(`edges of side ${side + 1}`, count, (n) => this.actions.count(side, n));
      this.fields.push(field);
      this.element.append(field.element);
    });
    this.sketch.corners.forEach((_, corner) => {
      const handle = this.makeHandle(corner);
      this.handles.push(handle);
      this.element.append(handle);
    });
    this.refresh();
    this.place();
  }

  /** Shows counts and kinds as they are now. */
  refresh(): void {
    this.fields.forEach((field, i) => field.set(this.sketch.counts[i]!));
    this.handles.forEach((handle, i) => {
      const kind = this.sketch.kinds[i]!;
      handle.classList.toggle("reflex", kind === "reflex");
      handle.setAttribute("aria-label", `corner ${i + 1}, ${kind}; arrow keys move it, Enter changes its kind`);
      handle.title = `${kind} corner: drag to move, double click to change`;
    });
  }

  private makeHandle(corner: number): HTMLButtonElement {
    const handle = make("button", { class: "handle", type: "button", "data-keys": true });
    let held = false;
    let moved = false;
    const follow = (event: PointerEvent, done: boolean): void => {
      const at = this.sketch.ground.pick(this.stage.castRay(event.clientX, event.clientY));
      this.actions.move(corner, at ?? this.sketch.corners[corner]!, done);
    };
    handle.addEventListener("pointerdown", (event) => {
      handle.setPointerCapture(event.pointerId);
      held = true;
      moved = false;
      event.stopPropagation();
    });
    handle.addEventListener("pointermove", (event) => {
      if (!held) return;
      moved = true;
      follow(event, false);
    });
    handle.addEventListener("pointerup", (event) => {
      if (held && moved) follow(event, true);
      held = false;
    });
    handle.addEventListener("pointercancel", () => (held = false));
    handle.addEventListener("dblclick", () => this.actions.toggle(corner));
    handle.addEventListener("keydown", (event) => {
      const step = { ArrowLeft: [-1, 0], ArrowRight: [1, 0], ArrowUp: [0, -1], ArrowDown: [0, 1] }[event.key];
      if (step) {
        const box = this.stage.canvas.getBoundingClientRect();
        const { x, y } = this.stage.project(this.sketch.corners[corner]!);
        const by = event.shiftKey ? NUDGE * 5 : NUDGE;
        const at = this.sketch.ground.pick(
          this.stage.castRay(box.left + x + step[0]! * by, box.top + y + step[1]! * by),
        );
        if (at) this.actions.move(corner, at, true);
      } else if (event.key === "Enter" || event.key === " ") {
        this.actions.toggle(corner);
      } else {
        return;
      }
      event.preventDefault();
      event.stopPropagation();
    });
    return handle;
  }

  private place(): void {
    const { sketch, stage } = this;
    const alone = stage.viewports.length === 1;
    this.element.hidden = !alone;
    if (!this.fields.length || !alone) return;
    const middle = stage.project(sketch.centre);
    const [right, low] = [stage.canvas.clientWidth - 20, stage.canvas.clientHeight - 16];
    sketch.getSides().forEach((side, i) => {
      const at = interpolateAlong(side, 0.5);
      const seen = stage.project(at);
      const out = this.findOutside(side, seen, middle);
      const x = Math.min(right, Math.max(20, seen.x + out.x * AWAY));
      const y = Math.min(low, Math.max(16, seen.y + out.y * AWAY));
      const { element } = this.fields[i]!;
      element.style.transform = `translate(-50%, -50%) translate(${x.toFixed(1)}px, ${y.toFixed(1)}px)`;
      element.classList.toggle("behind", this.isBehind(at));
    });
    sketch.corners.forEach((corner, i) => {
      const { x, y } = stage.project(corner);
      const handle = this.handles[i]!;
      handle.style.transform = `translate(-50%, -50%) translate(${x.toFixed(1)}px, ${y.toFixed(1)}px)`;
      handle.classList.toggle("behind", this.isBehind(corner));
    });
  }

  /** Across a side as it is seen, away from the polygon's inside. */
  private findOutside(
    side: readonly Point[],
    seen: { x: number; y: number },
    middle: { x: number; y: number },
  ): { x: number; y: number } {
    const a = this.stage.project(interpolateAlong(side, 0.4));
    const b = this.stage.project(interpolateAlong(side, 0.6));
    let [x, y] = [b.y - a.y, a.x - b.x];
    const size = Math.hypot(x, y);
    if (size < 1e-6) [x, y] = [seen.x - middle.x, seen.y - middle.y];
    // Sides run counter-clockwise, so that the outside is to the right, unless seen from behind.
    const behind = this.isBehind(interpolateAlong(side, 0.5));
    const by = (behind ? 1 : -1) / Math.max(1e-6, Math.hypot(x, y));
    return { x: x * by, y: y * by };
  }

  private isBehind(point: Point): boolean {
    const ground = this.sketch.ground;
    if (!ground.geometry) return false;
    return dot(ground.findNormal(point), subtract(this.stage.eye, point)) < -0.05 * distance(this.stage.eye, point);
  }
}

