/** Numbers as people write them: with a point or a comma, whatever the language. */

const COUNT = new Intl.NumberFormat("en");

/** Writes a count with its thousands apart: 425,428. */
export const formatCount = (n: number): string => COUNT.format(n);

const COMPACT = new Intl.NumberFormat("en", { notation: "compact", maximumSignificantDigits: 3 });

/** Writes a count in little room: 425K, 2.25M. */
export const formatCompact = (n: number): string => COMPACT.format(n);

/** "1 quad", "7 quads". */
export function formatPlural(n: number, one: string, many = `${one}s`): string {
  return `${formatCount(n)} ${n === 1 ? one : many}`;
}

/** Writes a measure with about three figures, for a field that reads both notations. */
export function formatMeasure(value: number): string {
  if (!Number.isFinite(value)) return "";
  return String(Number(value.toPrecision(3)));
}

/**
 * Reads a number in English or German: 1.5, 1,5, 1,234.5, 1.234,5, 1 234,5, 1'234.5.
 *
 * The last of two different marks is the decimal one; a mark that stands more than once separates
 * thousands. A single mark is the decimal one, since fields here take measures, which are small.
 * Returns null for what is no number.
 */
export function parseNumber(text: string): number | null {
  let t = text.trim().replace(/[\s\u00a0\u202f'’]/g, "").replace(/^[−–]/, "-");
  if (!/^[+-]?[\d.,]*\d[\d.,]*(e[+-]?\d+)?$/i.test(t)) return null;
  const points = t.split(".").length - 1;
  const commas = t.split(",").length - 1;
  if (points && commas) {
    const decimal = t.lastIndexOf(".") > t.lastIndexOf(",") ? "." : ",";
    if (t.split(decimal).length > 2) return null;
    const [whole, rest] = t.split(decimal) as [string, string];
    if (!hasThousands(whole, decimal === "." ? "," : ".")) return null;
    t = `${whole.replace(/[.,]/g, "")}.${rest}`;
  } else if (points > 1 || commas > 1) {
    if (!hasThousands(t, points ? "." : ",")) return null;
    t = t.replace(/[.,]/g, "");
  } else {
    t = t.replace(",", ".");
  }
  const value = Number(t);
  return Number.isFinite(value) ? value : null;
}

function hasThousands(whole: string, mark: string): boolean {
  const groups = whole.replace(/^[+-]/, "").split(mark);
  return groups.slice(1).every((g) => /^\d{3}$/.test(g)) && /^\d{1,3}$/.test(groups[0]!);
}

/** Reads a whole number of at least `least`: 12, 1.200 and 1,200 alike; null for anything else. */
export function parseWhole(text: string, least = 0): number | null {
  const t = text.trim();
  const grouped = /^\d{1,3}([.,\s'’]\d{3})+$/.test(t);
  const value = grouped ? Number(t.replace(/\D/g, "")) : parseNumber(t);
  return value !== null && Number.isInteger(value) && value >= least ? value : null;
}
