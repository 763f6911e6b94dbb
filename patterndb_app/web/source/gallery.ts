/** A strip of pictures to choose from: a list box, one of whose options is chosen. */

import { make } from "./dom.ts";

export interface GalleryItem {
  readonly picture: SVGElement;
  readonly title: string;
  readonly detail: string;
  /** What a screen reader says. */
  readonly label: string;
}

let galleries = 0;

export class Gallery {
  readonly element: HTMLDivElement;
  private readonly name = `gallery-${galleries++}`;
  private options: HTMLElement[] = [];
  private chosen = -1;
  private pinned: ReadonlySet<number> = new Set();

  constructor(
    label: string,
    empty: string,
    private readonly choose: (index: number) => void,
  ) {
    this.element = make("div", { class: "gallery", role: "listbox", tabindex: 0, "aria-label": label, "data-empty": empty, "aria-orientation": "horizontal" });
  }

  get length(): number {
    return this.options.length;
  }

  clear(): void {
    this.element.replaceChildren();
    this.element.removeAttribute("aria-activedescendant");
    this.options = [];
    this.chosen = -1;
  }

  add(item: GalleryItem): void {
    const index = this.options.length;
    const option = make(
      "div",
      {
        class: "option",
        role: "option",
        id: `${this.name}-${index}`,
        "aria-selected": "false",
        "aria-label": item.label,
        onclick: () => this.choose(index),
      },
      item.picture,
      make("span", { class: "option-title" }, item.title),
      make("span", { class: "option-detail" }, item.detail),
    );
    if (this.pinned.has(index)) option.classList.add("pinned");
    this.options.push(option);
    this.element.append(option);
  }

  select(index: number): void {
    this.options[this.chosen]?.setAttribute("aria-selected", "false");
    this.chosen = index;
    const option = this.options[index];
    if (!option) return;
    option.setAttribute("aria-selected", "true");
    this.element.setAttribute("aria-activedescendant", option.id);
    // Only the strip shall scroll, never the page.
    const left = option.offsetLeft - this.element.offsetLeft;
    const room = this.element.clientWidth;
    if (left < this.element.scrollLeft || left + option.offsetWidth > this.element.scrollLeft + room) {
      this.element.scrollTo({ left: left - room / 2 + option.offsetWidth / 2, behavior: "smooth" });
    }
  }

  mark(pinned: ReadonlySet<number>): void {
    this.pinned = pinned;
    this.options.forEach((option, i) => option.classList.toggle("pinned", pinned.has(i)));
  }
}

/** Which option a key leads to, from the one that is chosen; null for other keys. */
export function stepByKey(key: string, chosen: number, length: number): number | null {
  if (!length) return null;
  const last = length - 1;
  switch (key) {
    case "ArrowRight":
    case "ArrowDown":
      return Math.min(last, chosen + 1);
    case "ArrowLeft":
    case "ArrowUp":
      return Math.max(0, chosen - 1);
    case "PageDown":
      return Math.min(last, chosen + 8);
    case "PageUp":
      return Math.max(0, chosen - 8);
    case "Home":
      return 0;
    case "End":
      return last;
    default:
      return null;
  }
}
