/** Buttons with icons, and groups of them of which one is on. */

import { make, makeIcon } from "./dom.ts";
import { type IconName, ICONS } from "./icons.ts";

/** A button with an icon; its words are shown, or only told. */
export function makeButton(
  icon: IconName | null,
  words: string,
  press: () => void,
  options: { shown?: boolean; hint?: string; className?: string } = {},
): HTMLButtonElement {
  const shown = options.shown ?? true;
  return make(
    "button",
    {
      type: "button",
      class: options.className ?? "button",
      title: options.hint ?? (shown ? null : words),
      "aria-label": shown ? null : words,
      onclick: press,
    },
    icon && makeIcon(ICONS[icon]),
    shown && make("span", {}, words),
  );
}

export interface ChoiceButton {
  readonly value: string;
  readonly words: string;
  readonly icon?: IconName;
  readonly hint?: string;
}

/** Gives the arrow keys back to the fills after a click with the pointer, which leaves the focus. */
export function releaseFocus(element: HTMLElement): void {
  element.addEventListener("click", (event) => {
    // Keys click, too, but count no clicks.
    if (event.detail > 0 && document.activeElement instanceof HTMLElement) document.activeElement.blur();
  });
}

/** A group of buttons of which one is on: a radio group with one tab stop and arrow keys. */
export class ChoiceGroup {
  readonly element: HTMLDivElement;
  private readonly buttons = new Map<string, HTMLButtonElement>();

  constructor(label: string, className: string, choices: readonly ChoiceButton[], pick: (value: string) => void) {
    this.element = make("div", { class: className, role: "radiogroup", "aria-label": label, "data-keys": true });
    for (const choice of choices) {
      const button = makeButton(choice.icon ?? null, choice.words, () => pick(choice.value), {
        className: "choice",
        ...(choice.hint && { hint: choice.hint }),
      });
      button.setAttribute("role", "radio");
      this.buttons.set(choice.value, button);
      this.element.append(button);
    }
    this.element.addEventListener("keydown", (event) => {
      const step = { ArrowRight: 1, ArrowDown: 1, ArrowLeft: -1, ArrowUp: -1 }[event.key];
      if (!step) return;
      event.preventDefault();
      const all = [...this.buttons.values()];
      const at = all.findIndex((b) => b === document.activeElement);
      const next = all[(at + step + all.length) % all.length]!;
      next.focus();
      next.click();
    });
    releaseFocus(this.element);
    this.set("");
  }

  set(value: string): void {
    const known = this.buttons.has(value);
    let first = true;
    for (const [name, button] of this.buttons) {
      const on = name === value;
      button.setAttribute("aria-checked", String(on));
      button.tabIndex = on || (!known && first) ? 0 : -1;
      first = false;
    }
  }
}
