/** What the pointer does on the canvas: corners by clicks, strands and loops by drawing. */

import type { Stage } from "./scene.ts";
import type { Sketch } from "./sketch.ts";
import { distance, type Point, simplify } from "./vectors.ts";

export type Tool = "turn" | "corners" | "strand" | "loop";

export interface PointingActions {
  /** A corner was clicked, or, at the first one, the polygon closed. */
  corner(at: Point): void;
  close(): void;
  /** Where the next corner would be; null when the pointer has left the ground. */
  preview(at: Point | null, closes: boolean): void;
  /** A stroke while it is drawn, and as it is when it is done. */
  drawing(points: readonly Point[], loop: boolean): void;
  stroke(points: readonly Point[], loop: boolean): void;
}

/** Pixels that a pointer may move during a click. */
const STILL = 6;

/** Pixels within which a click means the first corner: more for a finger. */
const NEAR = { mouse: 14, touch: 26 };

export class Pointing {
  private tool: Tool = "corners";
  private down: { x: number; y: number; id: number } | null = null;
  private line: Point[] = [];
  private readonly fingers = new Set<number>();

  constructor(
    private readonly stage: Stage,
    private readonly sketch: Sketch,
    private readonly actions: PointingActions,
  ) {
    const { canvas } = stage;
    canvas.addEventListener("pointerdown", (event) => this.press(event));
    canvas.addEventListener("pointermove", (event) => this.move(event));
    canvas.addEventListener("pointerup", (event) => this.release(event));
    canvas.addEventListener("pointercancel", (event) => this.drop(event));
    canvas.addEventListener("pointerleave", () => this.actions.preview(null, false));
    canvas.addEventListener("dblclick", () => {
      if (this.tool === "corners" && !this.sketch.closed) this.actions.close();
    });
  }

  setTool(tool: Tool): void {
    this.tool = tool;
    this.line = [];
    this.stage.setOneFinger(tool === "strand" || tool === "loop" ? "draw" : "turn");
    this.stage.canvas.dataset.tool = tool;
  }

  private get isDrawing(): boolean {
    return this.tool === "strand" || this.tool === "loop";
  }

  private pick(event: PointerEvent): Point | null {
    return this.sketch.ground.pick(this.stage.castRay(event.clientX, event.clientY));
  }

  private press(event: PointerEvent): void {
    this.fingers.add(event.pointerId);
    if (event.button !== 0 || this.fingers.size > 1) {
      // A second finger means the camera: what the first one began was no drawing.
      this.line = [];
      this.down = null;
      if (this.isDrawing) this.actions.drawing([], false);
      return;
    }
    this.down = { x: event.clientX, y: event.clientY, id: event.pointerId };
    if (this.isDrawing) {
      this.stage.canvas.setPointerCapture(event.pointerId);
      const at = this.pick(event);
      this.line = at ? [at] : [];
    }
  }

  private move(event: PointerEvent): void {
    if (this.isDrawing) {
      if (this.down?.id !== event.pointerId) return;
      for (const one of event.getCoalescedEvents?.() ?? [event]) {
        const at = this.pick(one);
        const last = this.line.at(-1);
        if (at && (!last || distance(at, last) > this.stage.measurePixel() * 1.5)) this.line.push(at);
      }
      this.actions.drawing(this.line, this.tool === "loop");
    } else if (this.tool === "corners" && !this.sketch.closed && event.pointerType !== "touch") {
      const at = this.pick(event);
      this.actions.preview(at, at !== null && this.isFirst(at, event));
    }
  }

  private release(event: PointerEvent): void {
    this.fingers.delete(event.pointerId);
    const { down } = this;
    this.down = null;
    if (!down || down.id !== event.pointerId) return;
    if (this.isDrawing) {
      const drawn = simplify(this.line, this.stage.measurePixel() * 1.2);
      const loop = this.tool === "loop";
      this.line = [];
      this.actions.drawing([], loop);
      if (drawn.length >= (loop ? 4 : 2)) this.actions.stroke(drawn, loop);
    } else if (this.tool === "corners" && Math.hypot(event.clientX - down.x, event.clientY - down.y) < STILL) {
      const at = this.pick(event);
      if (!at) return;
      if (this.isFirst(at, event)) this.actions.close();
      // The second click of a double click stands where the first one stood.
      else if (!this.isLast(at)) this.actions.corner(at);
    }
  }

  private drop(event: PointerEvent): void {
    this.fingers.delete(event.pointerId);
    this.down = null;
    this.line = [];
    if (this.isDrawing) this.actions.drawing([], false);
  }

  private isFirst(at: Point, event: PointerEvent): boolean {
    const within = event.pointerType === "touch" ? NEAR.touch : NEAR.mouse;
    return !this.sketch.closed && this.sketch.isNearFirst(at, within * this.stage.measurePixel());
  }

  private isLast(at: Point): boolean {
    const last = this.sketch.closed ? undefined : this.sketch.corners.at(-1);
    return last !== undefined && distance(at, last) < STILL * this.stage.measurePixel();
  }
}
