/** Light and dark: the switch, what is remembered, and the colours of what is drawn. */

/** The same as VALENCE_COLOURS in viewer/style.py, which a test holds. */
export const VALENCE_COLOURS: Readonly<Record<number, string>> = {
  2: "#56b4e9",
  3: "#0072b2",
  5: "#d55e00",
  6: "#cc79a7",
  7: "#111111",
  8: "#009e73",
  9: "#b8860b",
  10: "#7b3294",
  11: "#8c510a",
  12: "#b3124c",
};

/** The same as TINTS in viewer/style.py: polychords, told apart in this order. */
export const TINTS: readonly string[] = [
  "#9cc3e6",
  "#f6c08a",
  "#a6d3a2",
  "#cbb2e0",
  "#f2e08e",
  "#90d3ce",
  "#f2b2c1",
  "#cfc0aa",
];

export function chooseValenceColour(valence: number): string {
  return VALENCE_COLOURS[Math.min(Math.max(valence, 2), 12)] ?? "#111111";
}

export const chooseTint = (group: number): string => TINTS[group % TINTS.length]!;

/** The colours of the scene; those of the page itself are in page.css. */
export interface Palette {
  readonly stage: string;
  readonly surface: string;
  readonly surfaceEdge: string;
  readonly quad: string;
  readonly edge: string;
  readonly boundary: string;
  readonly rim: string;
  readonly grid: string;
  readonly stroke: string;
  readonly selected: string;
  readonly loop: string;
  readonly filled: string;
  readonly filledEdge: string;
}

const LIGHT: Palette = {
  stage: "#ffffff",
  surface: "#bcc4d2",
  surfaceEdge: "#8b95a6",
  quad: "#fdfaf2",
  edge: "#4b5563",
  boundary: "#1f2733",
  rim: "#ffffff",
  grid: "#e9edf2",
  stroke: "#8a3ffc",
  selected: "#e4487f",
  loop: "#d55e00",
  filled: "#cfe3f6",
  filledEdge: "#1f4e79",
};

const DARK: Palette = {
  ...LIGHT,
  stage: "#11151c",
  surface: "#5c6880",
  surfaceEdge: "#333c4b",
  quad: "#e9e4d8",
  edge: "#3a4454",
  boundary: "#f3f5f9",
  rim: "#ffffff",
  grid: "#1d232e",
  stroke: "#a56eff",
  selected: "#ff6b9d",
  loop: "#ff8c3a",
  filled: "#a9cdef",
  filledEdge: "#123a5e",
};

type Choice = "light" | "dark";

const KEPT = "patterndb.theme";
const asksDark = window.matchMedia("(prefers-color-scheme: dark)");
const listeners = new Set<(palette: Palette) => void>();

/** What the reader chose, else what the system prefers. */
export function readTheme(): Choice {
  const kept = localStorage.getItem(KEPT);
  if (kept === "light" || kept === "dark") return kept;
  return asksDark.matches ? "dark" : "light";
}

export const readPalette = (): Palette => (readTheme() === "dark" ? DARK : LIGHT);

export function onTheme(listener: (palette: Palette) => void): void {
  listeners.add(listener);
  listener(readPalette());
}

/** Changes to the other theme; back at what the system prefers, it follows the system again. */
export function switchTheme(): Choice {
  const other = readTheme() === "dark" ? "light" : "dark";
  if ((other === "dark") === asksDark.matches) localStorage.removeItem(KEPT);
  else localStorage.setItem(KEPT, other);
  applyTheme();
  return other;
}

export function applyTheme(): void {
  document.documentElement.dataset.theme = readTheme();
  for (const listener of listeners) listener(readPalette());
}

asksDark.addEventListener("change", applyTheme);
