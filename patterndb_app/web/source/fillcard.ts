/** The card over the canvas: which fill is shown, what is known of it, what to do with it. */

import { makeButton } from "./buttons.ts";
import { make } from "./dom.ts";
import type { FillItem } from "./fillitem.ts";
import { formatCount, formatMeasure } from "./numbers.ts";
import { drawKey } from "./thumbnail.ts";

export interface CardActions {
  step(by: number): void;
  pin(): void;
  compare(): void;
  strands(): void;
  download(): void;
  link(): void;
}

export class FillCard {
  private readonly title = make("h2", { class: "card-title" });
  private readonly facts = make("dl", { class: "facts" });
  private readonly pin: HTMLButtonElement;
  private readonly compare: HTMLButtonElement;
  private readonly strands: HTMLButtonElement;

  constructor(
    private readonly element: HTMLElement,
    actions: CardActions,
  ) {
    const ghost = { shown: false, className: "button ghost" };
    this.pin = makeButton("pin", "Pin", () => actions.pin(), { hint: "keep this fill to compare (p)" });
    this.compare = makeButton("compare", "Compare", () => actions.compare(), { hint: "show pinned fills side by side (c)" });
    this.strands = makeButton("strands", "Strands", () => actions.strands(), { hint: "colour the strands of quads (t)" });
    element.append(
      make(
        "div",
        { class: "card-head" },
        this.title,
        makeButton("back", "previous fill", () => actions.step(-1), ghost),
        makeButton("next", "next fill", () => actions.step(1), ghost),
      ),
      this.facts,
      make(
        "div",
        { class: "card-actions" },
        this.pin,
        this.compare,
        this.strands,
        makeButton("link", "Copy link", () => actions.link()),
        makeButton("download", "Download OBJ", () => actions.download(), { className: "button primary wide", hint: "this fill as quads (d)" }),
      ),
    );
    element.hidden = true;
  }

  hide(): void {
    this.element.hidden = true;
  }

  show(item: FillItem, count: number, more: boolean): void {
    const { line } = item;
    this.element.hidden = false;
    this.title.textContent = `Fill ${item.rank} of ${count}${more ? "+" : ""}`;
    const irregular = make("span", { class: "keys" }, ...drawKey(item.valences));
    if (!item.valences.length) irregular.append("none inside");
    const rows: [string, Node | string][] = [
      ["pattern", make("a", { href: `#patterns?id=${line.pattern}`, class: "mono" }, line.pattern)],
      ["origin", line.origin],
      ["seen", line.frequency ? `${formatCount(line.frequency)} times` : "never"],
      ["quads", formatCount(line.quads.length)],
      ["irregular", irregular],
    ];
    if (line.n_irregular_boundary) rows.push(["on border", formatCount(line.n_irregular_boundary)]);
    if (line.flow_distance !== null) rows.push(["off strokes", formatMeasure(line.flow_distance) || "0"]);
    this.facts.replaceChildren(...rows.flatMap(([name, value]) => [make("dt", {}, name), make("dd", {}, value)]));
  }

  setState(state: { pinned: boolean; pins: number; comparing: boolean; strands: boolean }): void {
    this.pin.setAttribute("aria-pressed", String(state.pinned));
    this.pin.lastElementChild!.textContent = state.pinned ? "Pinned" : "Pin";
    this.compare.disabled = !state.pins;
    this.compare.setAttribute("aria-pressed", String(state.comparing));
    this.compare.lastElementChild!.textContent = state.pins ? `Compare ${state.pins}` : "Compare";
    this.strands.setAttribute("aria-pressed", String(state.strands));
  }
}
