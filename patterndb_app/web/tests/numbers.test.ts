import assert from "node:assert/strict";
import { test } from "node:test";
import { formatCompact, formatCount, formatMeasure, parseNumber, parseWhole } from "../source/numbers.ts";

test("numbers are read in English and German alike", () => {
  const cases: [string, number][] = [
    ["1.5", 1.5],
    ["1,5", 1.5],
    [" -0,25 ", -0.25],
    ["1,234.5", 1234.5],
    ["1.234,5", 1234.5],
    ["1 234,5", 1234.5],
    ["1'234.5", 1234.5],
    ["1.234.567", 1234567],
    ["1,234,567", 1234567],
    ["1e-3", 0.001],
    [".5", 0.5],
    [",5", 0.5],
    ["−2", -2],
  ];
  for (const [text, value] of cases) assert.equal(parseNumber(text), value, text);
});

test("what is no number is refused", () => {
  for (const text of ["", " ", "abc", "1.2.3", "1,2,3", "1.5,5.5", "--1", "1 mm", "12.34,5", "Infinity", "0x10"]) {
    assert.equal(parseNumber(text), null, text);
  }
});

test("whole numbers take either mark for thousands", () => {
  assert.equal(parseWhole("12"), 12);
  assert.equal(parseWhole("1.200"), 1200);
  assert.equal(parseWhole("1,200"), 1200);
  assert.equal(parseWhole("4,0"), 4);
  assert.equal(parseWhole("4.5"), null);
  assert.equal(parseWhole("0", 1), null);
  assert.equal(parseWhole("-3"), null);
});

test("what is written is read again", () => {
  for (let i = -8; i < 8; i++) {
    const value = Number((Math.PI * 10 ** i).toPrecision(3));
    assert.equal(parseNumber(formatMeasure(value)), value);
  }
  assert.equal(formatCount(425428), "425,428");
  assert.equal(formatCompact(2253978), "2.25M");
});
