/** The stage: one canvas with a camera that turns, and pictures drawn when something changed. */

import {
  AmbientLight,
  Color,
  DirectionalLight,
  Group,
  MOUSE,
  PerspectiveCamera,
  Raycaster,
  Scene,
  TOUCH,
  Vector2,
  Vector3,
  WebGLRenderer,
} from "three";
import { OrbitControls } from "three/examples/jsm/controls/OrbitControls.js";
import { dispose } from "./figure.ts";
import { lift, pixelRatio, resolution } from "./materials.ts";
import { onTheme, type Palette } from "./theme.ts";
import { add, distance, findCentre, normalize, type Point, scale } from "./vectors.ts";

const FIELD_OF_VIEW = 26;

/** A layer comes nearer by this share of its distance from the camera. */
const LIFT = 0.004;

/**
 * Where a processor draws, smooth edges in every picture would take half as long again. So they
 * come when nothing has changed for so many milliseconds, by so many pixels for one, each way.
 */
const STILL = 400;
const SMOOTHING = 2;

/** A part of the canvas, from its left upper corner, in shares of its size. */
export interface Viewport {
  readonly x: number;
  readonly y: number;
  readonly width: number;
  readonly height: number;
}

/** A picture on the canvas: all that is common, and one figure of its own. */
export interface StageView {
  readonly figure: Group;
  readonly viewport: Viewport;
}

const WHOLE: Viewport = { x: 0, y: 0, width: 1, height: 1 };

/** Is there no graphics card that draws? */
function drawsInSoftware(): boolean {
  const context = document.createElement("canvas").getContext("webgl2");
  const extension = context?.getExtension("WEBGL_debug_renderer_info");
  const name = extension && context!.getParameter(extension.UNMASKED_RENDERER_WEBGL);
  context?.getExtension("WEBGL_lose_context")?.loseContext();
  return /swiftshader|llvmpipe|softpipe|software/i.test(String(name));
}

export class Stage {
  readonly scene = new Scene();
  /** What every view shows. */
  readonly common = new Group();
  readonly camera = new PerspectiveCamera(FIELD_OF_VIEW, 1, 0.01, 1000);
  readonly controls: OrbitControls;
  private readonly renderer: WebGLRenderer;
  private readonly figures = new Group();
  private views: StageView[] = [];
  private asked = false;
  private drawing = true;
  private size = { width: 1, height: 1 };
  /** Pixels of the canvas for each of the screen, once nothing changes any more. */
  private readonly finest: number;
  private fineness = 1;
  private still = 0;
  private readonly drawnListeners = new Set<() => void>();
  private readonly onceDrawn: (() => void)[] = [];

  constructor(readonly canvas: HTMLCanvasElement) {
    const slow = drawsInSoftware();
    this.renderer = new WebGLRenderer({ canvas, antialias: !slow, powerPreference: "high-performance" });
    this.finest = slow ? SMOOTHING : 1;
    this.controls = new OrbitControls(this.camera, canvas);
    this.controls.enableDamping = false;
    this.controls.zoomToCursor = true;
    this.controls.rotateSpeed = 0.8;
    this.controls.addEventListener("change", () => this.draw());
    // Lambert's law divides by pi: what faces the camera has just its own colour.
    const key = new DirectionalLight("#ffffff", 0.62 * Math.PI);
    key.position.set(-0.4, 0.55, 1);
    this.camera.add(key, key.target);
    key.target.position.set(0, 0, -1);
    this.scene.add(this.camera, this.common, this.figures, new AmbientLight("#ffffff", 0.44 * Math.PI));
    new ResizeObserver(() => this.resize()).observe(canvas);
    onTheme((palette: Palette) => {
      this.renderer.setClearColor(new Color(palette.stage));
      this.draw();
    });
    this.lookAtPlane();
  }

  /** Shows nothing and draws nothing while another tab is open. */
  setDrawing(on: boolean): void {
    this.drawing = on;
    if (on) {
      this.resize();
      this.draw();
    }
  }

  /**
   * Shows figures, each in its own part of the canvas, seen by the same camera.
   *
   * room: pixels at the right that several figures shall leave free.
   */
  show(figures: readonly Group[], room = 0): void {
    this.figures.clear();
    if (figures.length) this.figures.add(...figures);
    const columns = figures.length < 2 || this.size.width > this.size.height ? figures.length : 1;
    const rows = Math.ceil(figures.length / Math.max(1, columns));
    const whole = columns > 1 ? Math.max(0.5, 1 - room / this.size.width) : 1;
    this.views = figures.map((figure, i) => ({
      figure,
      viewport: {
        x: ((i % columns) * whole) / columns,
        y: Math.floor(i / columns) / rows,
        width: whole / columns,
        height: 1 / rows,
      },
    }));
    this.draw();
  }

  get viewports(): readonly Viewport[] {
    return this.views.length ? this.views.map((v) => v.viewport) : [WHOLE];
  }

  onDrawn(listener: () => void): void {
    this.drawnListeners.add(listener);
  }

  /** Draws a figure where nobody sees it, so that its programs are ready when one is shown. */
  prepare(figure: Group): void {
    this.scene.add(figure);
    this.renderer.setScissorTest(true);
    this.renderer.setScissor(0, 0, 1, 1);
    this.renderer.render(this.scene, this.camera);
    dispose(figure);
    this.draw();
  }

  /** Calls back once after the next picture. */
  afterPicture(callback: () => void): void {
    this.onceDrawn.push(callback);
    this.draw();
  }

  draw(): void {
    clearTimeout(this.still);
    if (this.asked) return;
    this.asked = true;
    requestAnimationFrame(() => {
      this.asked = false;
      if (!this.drawing) return;
      this.setFineness(1);
      this.drawNow();
      if (this.finest > 1) this.still = window.setTimeout(() => this.drawStill(), STILL);
    });
  }

  /** Draws the same picture with smooth edges. */
  private drawStill(): void {
    requestAnimationFrame(() => {
      if (this.asked || !this.drawing) return;
      this.setFineness(this.finest);
      this.drawViews();
    });
  }

  /** Sets the canvas's pixels for each of the screen; its picture is lost when they change. */
  private setFineness(fineness: number): void {
    if (fineness === this.fineness) return;
    this.fineness = fineness;
    this.fitCanvas();
  }

  private drawNow(): void {
    this.drawViews();
    for (const listener of this.drawnListeners) listener();
    for (const callback of this.onceDrawn.splice(0)) callback();
  }

  private drawViews(): void {
    const { width, height } = this.size;
    const { near, far } = this.camera;
    lift.value = (LIFT * 2 * far * near) / (far - near);
    const views = this.views.length ? this.views : [{ figure: null, viewport: WHOLE }];
    this.renderer.setScissorTest(false);
    this.renderer.setViewport(0, 0, width, height);
    this.renderer.clear();
    this.renderer.setScissorTest(true);
    for (const { figure, viewport } of views) {
      const [x, y] = [viewport.x * width, (1 - viewport.y - viewport.height) * height];
      const [w, h] = [viewport.width * width, viewport.height * height];
      for (const other of this.figures.children) other.visible = other === figure;
      this.aim(w, h);
      resolution.set(w, h);
      this.renderer.setViewport(x, y, w, h);
      this.renderer.setScissor(x, y, w, h);
      this.renderer.render(this.scene, this.camera);
    }
  }

  /** Sets the camera's view to a part of the canvas; what fits into the whole fits into it. */
  private aim(width: number, height: number): void {
    const whole = Math.min(1, this.size.width / this.size.height);
    this.camera.aspect = width / height;
    this.camera.zoom = Math.min(1, width / height / whole);
    this.camera.updateProjectionMatrix();
  }

  private resize(): void {
    const width = this.canvas.clientWidth;
    const height = this.canvas.clientHeight;
    if (!width || !height) return;
    this.size = { width, height };
    this.fitCanvas();
    this.draw();
  }

  private fitCanvas(): void {
    pixelRatio.value = Math.min(window.devicePixelRatio || 1, 2) * this.fineness;
    this.renderer.setPixelRatio(pixelRatio.value);
    this.renderer.setSize(this.size.width, this.size.height, false);
  }

  /** Where a point is seen, in pixels from the canvas's left upper corner, in the first view. */
  project(point: Point): { x: number; y: number; depth: number } {
    const seen = new Vector3(...point).project(this.camera);
    const [view] = this.viewports;
    return {
      x: ((seen.x + 1) / 2) * this.size.width * view!.width,
      y: ((1 - seen.y) / 2) * this.size.height * view!.height,
      depth: seen.z,
    };
  }

  /** The ray through a place on the page. */
  castRay(clientX: number, clientY: number): Raycaster {
    const box = this.canvas.getBoundingClientRect();
    const u = (clientX - box.left) / box.width;
    const v = (clientY - box.top) / box.height;
    const view =
      this.viewports.find((p) => u >= p.x && u < p.x + p.width && v >= p.y && v < p.y + p.height) ?? WHOLE;
    const at = new Vector2(((u - view.x) / view.width) * 2 - 1, 1 - ((v - view.y) / view.height) * 2);
    const ray = new Raycaster();
    this.aim(view.width * box.width, view.height * box.height);
    ray.setFromCamera(at, this.camera);
    return ray;
  }

  get eye(): Point {
    return this.camera.position.toArray();
  }

  get up(): Point {
    return new Vector3(0, 1, 0).applyQuaternion(this.camera.quaternion).toArray();
  }

  /** World units that a pixel of the page covers at the centre of what is looked at. */
  measurePixel(): number {
    const away = this.camera.position.distanceTo(this.controls.target);
    const high = 2 * away * Math.tan((FIELD_OF_VIEW * Math.PI) / 360);
    return high / Math.max(1, this.size.height);
  }

  /** Looks straight at the plane z = 0; the camera only shifts and zooms. */
  lookAtPlane(): void {
    this.controls.enableRotate = false;
    this.camera.up.set(0, 1, 0);
    this.place([0, 0, 0], [0, 0, 1], 5.6);
    this.setOneFinger("turn");
  }

  /** Looks at a surface from one side; the camera turns around it. */
  lookAtSurface(points: readonly Point[], from: Point): void {
    this.controls.enableRotate = true;
    this.frame(points, from);
    this.setOneFinger("turn");
  }

  /** Fits points into the canvas, seen from a direction, or from where the camera is. */
  frame(points: readonly Point[], from?: Point, margin = 1.25): void {
    if (!points.length) return;
    const centre = this.findMiddle(points);
    const radius = Math.max(1e-6, ...points.map((p) => distance(p, centre)));
    const half = Math.tan((FIELD_OF_VIEW * Math.PI) / 360);
    const aspect = Math.min(1, this.size.width / Math.max(1, this.size.height));
    const direction = from ?? this.camera.position.clone().sub(this.controls.target).toArray();
    this.place(centre, direction, (radius * margin) / (half * aspect));
  }

  private findMiddle(points: readonly Point[]): Point {
    const low = points.reduce((a, p) => p.map((x, i) => Math.min(x, a[i]!)) as unknown as Point);
    const high = points.reduce((a, p) => p.map((x, i) => Math.max(x, a[i]!)) as unknown as Point);
    return findCentre([low, high]);
  }

  private place(centre: Point, from: Point, away: number): void {
    this.controls.target.set(...centre);
    this.camera.position.set(...add(centre, scale(normalize(from), away)));
    this.camera.near = away / 50;
    this.camera.far = away * 20;
    this.controls.minDistance = away / 20;
    this.controls.maxDistance = away * 6;
    this.controls.update();
    this.draw();
  }

  /** What one finger or the left button does when it is dragged: turn the camera, or draw. */
  setOneFinger(use: "turn" | "draw"): void {
    const { controls } = this;
    const turn = controls.enableRotate ? MOUSE.ROTATE : MOUSE.PAN;
    controls.mouseButtons = {
      LEFT: use === "turn" ? turn : null,
      MIDDLE: MOUSE.DOLLY,
      RIGHT: MOUSE.PAN,
    };
    controls.touches = {
      ONE: use === "turn" ? (controls.enableRotate ? TOUCH.ROTATE : TOUCH.PAN) : null,
      TWO: controls.enableRotate ? TOUCH.DOLLY_ROTATE : TOUCH.DOLLY_PAN,
    };
  }
}
