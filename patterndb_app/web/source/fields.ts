/** Fields of the page's forms: counts by wheel, keys or digits; measures; choices; switches. */

import { make } from "./dom.ts";
import { formatMeasure, parseNumber, parseWhole } from "./numbers.ts";

export interface CountField {
  readonly element: HTMLInputElement;
  set(value: number): void;
}

/** The most edges of a boundary: what the library takes. */
const MOST = 2000;

/** A field for a whole number: digits, arrow keys or the wheel change it. */
export function makeCountField(label: string, value: number, change: (value: number) => void): CountField {
  let current = value;
  const element = make("input", {
    class: "count",
    type: "text",
    inputmode: "numeric",
    autocomplete: "off",
    role: "spinbutton",
    "aria-label": label,
    "aria-valuemin": 1,
    "aria-valuemax": MOST,
  });
  const set = (next: number): void => {
    current = next;
    if (document.activeElement !== element || parseWhole(element.value) !== next) element.value = String(next);
    element.setAttribute("aria-valuenow", String(next));
    element.removeAttribute("aria-invalid");
  };
  const step = (by: number): void => {
    const next = Math.min(MOST, Math.max(1, current + by));
    if (next === current) return;
    set(next);
    change(next);
  };
  element.addEventListener("input", () => {
    const next = parseWhole(element.value, 1);
    if (next === null || next > MOST) {
      element.setAttribute("aria-invalid", "true");
    } else if (next !== current) {
      set(next);
      change(next);
    }
  });
  element.addEventListener("blur", () => set(current));
  element.addEventListener("focus", () => element.select());
  element.addEventListener("keydown", (event) => {
    const by = { ArrowUp: 1, ArrowDown: -1, PageUp: 5, PageDown: -5 }[event.key];
    if (event.key === "Enter" || event.key === "Escape") element.blur();
    if (by === undefined) return;
    event.preventDefault();
    step(by);
  });
  let turned = 0;
  element.addEventListener(
    "wheel",
    (event) => {
      event.preventDefault();
      event.stopPropagation();
      // A trackpad sends many small turns, a wheel few large ones.
      turned += event.deltaMode === WheelEvent.DOM_DELTA_PIXEL ? event.deltaY / 40 : event.deltaY;
      const steps = Math.trunc(turned);
      turned -= steps;
      if (steps) step(-Math.sign(steps));
    },
    { passive: false },
  );
  set(value);
  return { element, set };
}

export interface MeasureField {
  readonly element: HTMLInputElement;
  set(value: number | null): void;
}

/** A field for a number, read in English and German; empty means null. */
export function makeMeasureField(
  id: string,
  placeholder: string,
  change: (value: number | null) => void,
  accept: (value: number) => boolean,
): MeasureField {
  const element = make("input", { id, class: "measure", type: "text", inputmode: "decimal", autocomplete: "off", placeholder });
  element.addEventListener("change", () => {
    const value = element.value.trim() ? parseNumber(element.value) : null;
    const good = value === null ? !element.value.trim() : accept(value);
    if (good) {
      element.removeAttribute("aria-invalid");
      change(value);
    } else {
      element.setAttribute("aria-invalid", "true");
    }
  });
  element.addEventListener("keydown", (event) => {
    if (event.key === "Enter") element.blur();
  });
  const set = (value: number | null): void => {
    if (document.activeElement === element) return;
    element.value = value === null ? "" : formatMeasure(value);
    element.removeAttribute("aria-invalid");
  };
  return { element, set };
}

/** A line of a form: its label and what is labelled. */
export function makeRow(label: string, field: HTMLElement, id: string): HTMLElement {
  field.id = id;
  return make("div", { class: "row" }, make("label", { for: id }, label), field);
}

export function makeSwitch(id: string, label: string, on: boolean, change: (on: boolean) => void): HTMLElement {
  const box = make("input", { type: "checkbox", id });
  box.checked = on;
  box.addEventListener("change", () => change(box.checked));
  return make("label", { class: "switch", for: id }, box, make("span", {}, label));
}

export function makeSelect(
  id: string,
  choices: readonly (readonly [value: string, title: string])[],
  value: string,
  change: (value: string) => void,
): HTMLSelectElement {
  const select = make("select", { id }, ...choices.map(([v, title]) => make("option", { value: v, selected: v === value }, title)));
  select.addEventListener("change", () => change(select.value));
  return select;
}
