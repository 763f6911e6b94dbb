/** Elements of the page, made by one call each. */

type Child = Node | string | null | undefined | false;
type Value = string | number | boolean | null | undefined | ((event: never) => void);
export type Attributes = Readonly<Record<string, Value>>;

const SVG = "http://www.w3.org/2000/svg";

/**
 * Makes an element. Functions under "on..." become listeners, true an attribute without a value;
 * false, null and undefined leave an attribute out.
 */
export function make<K extends keyof HTMLElementTagNameMap>(
  tag: K,
  attributes: Attributes = {},
  ...children: Child[]
): HTMLElementTagNameMap[K] {
  return dress(document.createElement(tag), attributes, children);
}

export function makeSvg<K extends keyof SVGElementTagNameMap>(
  tag: K,
  attributes: Attributes = {},
  ...children: Child[]
): SVGElementTagNameMap[K] {
  return dress(document.createElementNS(SVG, tag), attributes, children);
}

function dress<E extends Element>(element: E, attributes: Attributes, children: Child[]): E {
  for (const [name, value] of Object.entries(attributes)) {
    if (typeof value === "function") {
      element.addEventListener(name.slice(2), value as EventListener);
    } else if (value !== false && value !== null && value !== undefined) {
      element.setAttribute(name, value === true ? "" : String(value));
    }
  }
  element.append(...children.filter((c): c is Node | string => c !== null && c !== undefined && c !== false));
  return element;
}

/** The element of the page with this id, which index.html must have. */
export function find<T extends HTMLElement = HTMLElement>(id: string): T {
  const element = document.getElementById(id);
  if (!element) throw new Error(`index.html has no element ${id}`);
  return element as T;
}

/** Says a sentence to screen readers, when they have time for it. */
export function announce(text: string): void {
  const place = find("announcement");
  place.textContent = "";
  // The same sentence twice is read twice only if it changes in between.
  requestAnimationFrame(() => (place.textContent = text));
}

/** Draws an icon of strokes on a 20 by 20 grid. */
export function makeIcon(path: string): SVGSVGElement {
  return makeSvg(
    "svg",
    { viewBox: "0 0 20 20", class: "icon", "aria-hidden": "true" },
    makeSvg("path", { d: path }),
  );
}

/** Gives the reader a file. */
export function saveFile(name: string, content: string, type = "model/obj"): void {
  const url = URL.createObjectURL(new Blob([content], { type }));
  const link = make("a", { href: url, download: name });
  link.click();
  setTimeout(() => URL.revokeObjectURL(url), 1000);
}

/** Does the focus take letters and arrow keys for itself? */
export function isTyping(): boolean {
  const element = document.activeElement;
  return element instanceof HTMLElement && element.closest("input, select, textarea, [data-keys]") !== null;
}
