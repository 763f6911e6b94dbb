import assert from "node:assert/strict";
import { test } from "node:test";
import { isEven, offerEven, spreadCounts, sum } from "../source/counts.ts";

test("counts are even, at least 4 in all, and none is 0", () => {
  for (let seed = 1; seed < 400; seed++) {
    const lengths = Array.from({ length: 2 + (seed % 6) }, (_, i) => ((seed * (i + 3) * 7919) % 97) / 10 + 0.01);
    for (const edge of [0.05, 0.7, 3, 100]) {
      const counts = spreadCounts(lengths, edge);
      assert.ok(isEven(counts) && sum(counts) >= 4 && Math.min(...counts) >= 1, `${lengths} ${edge} ${counts}`);
    }
  }
});

test("counts follow the lengths as nearly as an even sum allows", () => {
  assert.deepEqual(spreadCounts([4, 3, 4, 3], 1), [4, 3, 4, 3]);
  assert.deepEqual(spreadCounts([4, 3.4, 4, 2], 1), [4, 4, 4, 2]);
});

test("an odd perimeter is offered even ones, an edge away", () => {
  const offers = offerEven([5, 4, 6, 4, 4], [5, 4, 6.6, 4, 4]);
  assert.equal(offers.length, 4);
  for (const { counts, side, step } of offers) {
    assert.ok(isEven(counts));
    assert.equal(Math.abs(sum(counts) - 23), 1);
    assert.equal(counts[side], [5, 4, 6, 4, 4][side]! + step);
  }
  assert.deepEqual([offers[0]!.side, offers[0]!.step], [2, 1]);
  assert.deepEqual(offerEven([4, 4, 4, 4]), []);
});

test("a side keeps an edge", () => {
  assert.ok(offerEven([1, 1, 1, 2]).every(({ counts }) => Math.min(...counts) >= 1));
});
