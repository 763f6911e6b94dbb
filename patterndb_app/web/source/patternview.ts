/** The tab Patterns: what the database holds, by filters; one pattern large. */

import { askPattern, askPatterns, askStats, type PatternDetail, type PatternRow, type Statistics } from "./api.ts";
import { makeButton } from "./buttons.ts";
import { announce, find, make } from "./dom.ts";
import { makeMeasureField, makeRow, makeSelect, makeSwitch } from "./fields.ts";
import { section } from "./fillpanel.ts";
import { readMessage } from "./fillview.ts";
import { formatCount, formatPlural } from "./numbers.ts";
import { drawPattern } from "./patternfigure.ts";
import { formatPlace } from "./permalink.ts";
import { drawKey } from "./thumbnail.ts";

export class PatternView {
  private readonly cards = find("pattern-cards");
  private readonly detail = find("pattern-detail");
  private readonly status = find("pattern-status");
  private readonly more = makeButton(null, "More patterns", () => void this.load(), { className: "button wide" });
  private filters = new URLSearchParams();
  private cursor: string | null = null;
  private chosen = "";
  private count = 0;
  private search: AbortController | null = null;
  private started = false;
  private stats: Statistics | null = null;

  constructor() {
    find("pattern-more").append(this.more);
    this.more.hidden = true;
    this.cards.addEventListener("keydown", (event) => this.walk(event));
  }

  /** Shows what an address says: filters, and the pattern that is looked at. */
  async show(values: URLSearchParams): Promise<void> {
    const id = values.get("id") ?? "";
    const filters = new URLSearchParams(values);
    filters.delete("id");
    if (!this.started && ![...filters].length) filters.set("sides", "5");
    const changed = !this.started || ([...filters].length > 0 && filters.toString() !== this.filters.toString());
    if (changed) {
      this.filters = filters;
      this.makeFilters();
      if (!this.stats) void this.loadStats();
    }
    this.started = true;
    await Promise.all([changed ? this.reload() : null, id ? this.open(id) : null]);
  }

  handleKey(event: KeyboardEvent): void {
    if (event.key === "Escape") this.close();
  }

  private makeFilters(): void {
    const { filters } = this;
    const set = (name: string, value: string): void => {
      if (value) filters.set(name, value);
      else filters.delete(name);
      this.keepAddress();
      void this.reload();
    };
    const sides = makeSelect(
      "pattern-sides",
      [["", "any"], ...this.listSides(filters.get("sides"))],
      filters.get("sides") ?? "",
      (value) => set("sides", value),
    );
    const order = makeSelect(
      "pattern-order",
      [
        ["", "seen most"],
        ["irregular", "fewest irregular vertices"],
        ["quads", "fewest quads"],
      ],
      filters.get("order") ?? "",
      (value) => set("order", value),
    );
    const most = makeMeasureField(
      "pattern-irregular",
      "any",
      (value) => set("max_irregular", value === null ? "" : String(value)),
      (value) => Number.isInteger(value) && value >= 0,
    );
    const kept = filters.get("max_irregular");
    most.set(kept === null ? null : Number(kept));
    const convex = makeSwitch("pattern-convex", "Convex corners only", filters.get("convex") === "true", (on) => set("convex", on ? "true" : ""));
    find("pattern-filters").replaceChildren(
      section(
        "Which patterns",
        makeRow("Sides", sides, "pattern-sides"),
        makeRow("Max. irregular", most.element, "pattern-irregular"),
        makeRow("First come", order, "pattern-order"),
        convex,
      ),
      section("The database", make("dl", { class: "facts", id: "stats" })),
    );
    this.showStats();
  }

  /** Numbers of sides that there are patterns of, with how many; before that is known, the asked. */
  private listSides(asked: string | null): (readonly [string, string])[] {
    const counted = Object.entries(this.stats?.by_sides ?? {});
    if (!counted.length) return asked ? [[asked, asked]] : [];
    return counted
      .sort(([a], [b]) => Number(a) - Number(b))
      .map(([sides, count]) => [sides, `${sides}  (${formatCount(count)})`]);
  }

  private async loadStats(): Promise<void> {
    try {
      this.stats = await askStats();
      this.makeFilters();
    } catch {
      // The list of patterns says what is wrong; figures beside it are no loss.
    }
  }

  private showStats(): void {
    const { stats } = this;
    if (!stats) return;
    const rows = (["patterns", "meshes", "patches"] as const).flatMap((name) => [
      make("dt", {}, name),
      make("dd", {}, formatCount(stats[name])),
    ]);
    find("stats").replaceChildren(...rows);
  }

  private async reload(): Promise<void> {
    this.search?.abort();
    this.search = new AbortController();
    this.cursor = null;
    this.count = 0;
    this.cards.replaceChildren();
    await this.load();
  }

  private async load(): Promise<void> {
    const signal = this.search?.signal;
    const query = new URLSearchParams(this.filters);
    if (this.cursor) query.set("cursor", this.cursor);
    this.cards.setAttribute("aria-busy", "true");
    this.status.classList.remove("error");
    this.status.textContent = this.count ? "" : "Looking …";
    try {
      const page = await askPatterns(query, signal);
      if (signal?.aborted) return;
      const before = this.count;
      this.count += page.patterns.length;
      this.cards.append(...page.patterns.map((row) => this.makeCard(row)));
      this.cursor = page.next;
      this.more.hidden = !page.next;
      this.status.textContent = this.count
        ? `${formatPlural(this.count, "pattern")}${page.next ? ", and there are more" : ""}`
        : "There is no such pattern: loosen a filter.";
      if (before === 0) announce(this.status.textContent);
    } catch (error) {
      if (signal?.aborted) return;
      this.status.textContent = readMessage(error);
      this.status.classList.add("error");
    } finally {
      if (!signal?.aborted) this.cards.setAttribute("aria-busy", "false");
    }
  }

  private makeCard(row: PatternRow): HTMLElement {
    const card = make(
      "button",
      {
        type: "button",
        class: "pattern-card",
        "data-id": row.id,
        "aria-label": `pattern ${row.id}: ${formatPlural(row.n_quads, "quad")}, ${row.n_irregular} irregular, seen ${formatCount(row.frequency)} times`,
        onclick: () => void this.open(row.id),
      },
      // Below the pattern its picture has a caption, which the style cuts off: this card has its own.
      make("span", { class: "cut" }, make("span", {}, make("img", { src: row.svg.replace(/^\//, ""), alt: "", loading: "lazy" }))),
      make("span", { class: "option-title" }, `${formatCount(row.frequency)}×`),
      make("span", { class: "option-detail" }, `${formatPlural(row.n_quads, "quad")} · ${row.n_irregular} irregular`),
    );
    card.classList.toggle("on", row.id === this.chosen);
    return card;
  }

  /** Arrow keys go from card to card. */
  private walk(event: KeyboardEvent): void {
    const cards = [...this.cards.children] as HTMLElement[];
    const at = cards.indexOf(document.activeElement as HTMLElement);
    if (at < 0) return;
    const columns = Math.max(1, cards.filter((c) => c.offsetTop === cards[0]!.offsetTop).length);
    const step = { ArrowRight: 1, ArrowLeft: -1, ArrowDown: columns, ArrowUp: -columns }[event.key];
    if (!step) return;
    event.preventDefault();
    cards[Math.min(cards.length - 1, Math.max(0, at + step))]!.focus();
  }

  private async open(id: string): Promise<void> {
    this.chosen = id;
    for (const card of this.cards.children) card.classList.toggle("on", (card as HTMLElement).dataset.id === id);
    this.keepAddress();
    try {
      const pattern = await askPattern(id);
      if (this.chosen === id) this.showDetail(pattern);
    } catch (error) {
      this.detail.hidden = false;
      this.detail.replaceChildren(make("p", { class: "status error" }, readMessage(error)));
    }
  }

  private close(): void {
    this.chosen = "";
    this.detail.hidden = true;
    for (const card of this.cards.children) card.classList.remove("on");
    this.keepAddress();
  }

  private showDetail(pattern: PatternDetail): void {
    const { picture, list } = drawPattern(pattern.quads, pattern.vertices, new Set(pattern.corner_vertices));
    const valences = pattern.valences;
    const facts: [string, Node | string][] = [
      ["sides", String(pattern.sides)],
      ["quads", formatCount(pattern.n_quads)],
      ["irregular", valences.length ? make("span", { class: "keys" }, ...drawKey(valences)) : "none inside"],
      ["seen", `${formatCount(pattern.frequency)} times`],
    ];
    this.detail.replaceChildren(
      make(
        "div",
        { class: "card-head" },
        make("h2", { class: "card-title mono" }, pattern.id),
        makeButton("close", "close", () => this.close(), { shown: false, className: "button ghost" }),
      ),
      picture,
      make("dl", { class: "facts" }, ...facts.flatMap(([name, value]) => [make("dt", {}, name), make("dd", {}, value)])),
      section("Polychords", list),
      section("Where it was seen", makeOccurrences(pattern)),
    );
    this.detail.hidden = false;
    announce(`pattern ${pattern.id}, ${formatPlural(pattern.n_quads, "quad")}`);
  }

  private keepAddress(): void {
    const values = new URLSearchParams(this.filters);
    if (this.chosen) values.set("id", this.chosen);
    history.replaceState(null, "", formatPlace("patterns", values));
  }
}

/** The meshes that a pattern occurs in, and under which licence each is. */
function makeOccurrences(pattern: PatternDetail): HTMLElement {
  if (!pattern.occurrences.length) return make("p", { class: "hint" }, "In no mesh: it comes from a table.");
  const rows = pattern.occurrences.map((o) =>
    make("tr", {}, make("td", {}, o.mesh), make("td", {}, o.licence ?? "unknown"), make("td", { class: "number" }, formatCount(o.count))),
  );
  return make(
    "div",
    { class: "scrolling", tabindex: 0, role: "region", "aria-label": "meshes" },
    make(
      "table",
      {},
      make("thead", {}, make("tr", {}, make("th", { scope: "col" }, "Mesh"), make("th", { scope: "col" }, "Licence"), make("th", { scope: "col", class: "number" }, "Patches"))),
      make("tbody", {}, ...rows),
    ),
  );
}
