/** The page: three tabs, one address for each state of them. */

import { releaseFocus } from "./buttons.ts";
import { makeIcon, find, isTyping } from "./dom.ts";
import { FillView } from "./fillview.ts";
import { HoleView } from "./holeview.ts";
import { ICONS } from "./icons.ts";
import { formatPlace, parsePlace } from "./permalink.ts";
import { PatternView } from "./patternview.ts";
import { applyTheme, onTheme, readTheme, switchTheme } from "./theme.ts";

const TABS = ["fill", "patterns", "hole"] as const;
type Tab = (typeof TABS)[number];

let current: Tab = "fill";
/** The address of each tab as it was left. */
const addresses = new Map<Tab, string>();
const views: { fill?: FillView; patterns?: PatternView; hole?: HoleView } = {};

/** Shows a tab; its view is made when it is first opened. */
async function openTab(tab: Tab, values: URLSearchParams | null): Promise<void> {
  current = tab;
  for (const name of TABS) {
    const button = find(`tab-${name}`);
    button.setAttribute("aria-selected", String(name === tab));
    button.tabIndex = name === tab ? 0 : -1;
    find(`panel-${name}`).hidden = name !== tab;
  }
  views.fill?.setShown(tab === "fill");
  views.hole?.setShown(tab === "hole");
  if (tab === "fill") {
    if (!views.fill) {
      views.fill = new FillView();
      await views.fill.start(values ?? new URLSearchParams());
    } else if (values) {
      await views.fill.restore(values);
    }
  } else if (tab === "patterns") {
    views.patterns ??= new PatternView();
    await views.patterns.show(values ?? new URLSearchParams());
  } else {
    views.hole ??= new HoleView();
    await views.hole.show(values ?? new URLSearchParams());
  }
}

function readTab(name: string): Tab {
  return TABS.find((tab) => tab === name) ?? "fill";
}

function switchTab(tab: Tab): void {
  addresses.set(current, location.hash);
  history.replaceState(null, "", addresses.get(tab) ?? formatPlace(tab, new URLSearchParams()));
  void openTab(tab, null);
}

function wireTabs(): void {
  releaseFocus(find("tabs"));
  for (const tab of TABS) find(`tab-${tab}`).addEventListener("click", () => switchTab(tab));
  find("tabs").addEventListener("keydown", (event) => {
    const step = { ArrowRight: 1, ArrowLeft: -1 }[event.key];
    if (!step) return;
    event.preventDefault();
    const next = TABS[(TABS.indexOf(current) + step + TABS.length) % TABS.length]!;
    switchTab(next);
    find(`tab-${next}`).focus();
  });
  // A link that is followed or pasted; the page itself changes its address without this event.
  window.addEventListener("hashchange", (event) => {
    addresses.set(current, new URL(event.oldURL).hash);
    const { tab, values } = parsePlace(location.hash);
    void openTab(readTab(tab), values);
  });
  document.addEventListener("keydown", (event) => {
    if (event.altKey || isTyping()) return;
    const onButton = document.activeElement instanceof HTMLButtonElement || document.activeElement instanceof HTMLAnchorElement;
    if (onButton && (event.key === "Enter" || event.key === " ")) return;
    views[current]?.handleKey(event);
  });
}

function wireTheme(): void {
  const button = find("theme");
  button.addEventListener("click", () => switchTheme());
  onTheme(() => {
    const dark = readTheme() === "dark";
    button.replaceChildren(makeIcon(dark ? ICONS.sun : ICONS.moon));
    button.setAttribute("aria-label", dark ? "light colours" : "dark colours");
    button.title = dark ? "light colours" : "dark colours";
  });
}

applyTheme();
wireTheme();
wireTabs();
const { tab, values } = parsePlace(location.hash);
void openTab(readTab(tab), values);
