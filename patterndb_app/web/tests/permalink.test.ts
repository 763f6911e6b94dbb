import assert from "node:assert/strict";
import { test } from "node:test";
import { decodeQuestion, encodeQuestion, formatPlace, parsePlace, type Question } from "../source/permalink.ts";

const QUESTION: Question = {
  surface: "ball",
  corners: [[-1, 0.25, 0.5], [1, -0.125, 0.5], [0.333333, 1, 0]],
  kinds: ["convex", "reflex", "convex"],
  counts: [4, 5, 7],
  strokes: [
    { points: [[0, 0, 1], [0.5, 0.5, 0.5]], loop: false },
    { points: [[0, 0, 1], [0.5, 0, 1], [0, 0.5, 1]], loop: true },
  ],
  options: { order: "regular", strict: "1" },
  rank: 3,
};

test("a question comes back from its address", () => {
  const hash = formatPlace("fill", encodeQuestion(QUESTION));
  const { tab, values } = parsePlace(hash);
  assert.equal(tab, "fill");
  assert.deepEqual(decodeQuestion(values), QUESTION);
});

test("the address of the same question is the same", () => {
  const first = encodeQuestion(QUESTION).toString();
  const again = decodeQuestion(parsePlace(`#fill?${first}`).values);
  assert.equal(encodeQuestion(again!).toString(), first);
});

test("an empty address is an empty question in the plane", () => {
  const question = decodeQuestion(parsePlace("").values);
  assert.equal(question?.surface, "plane");
  assert.equal(question?.corners.length, 0);
});

test("what is no question is refused", () => {
  for (const query of ["c=1,2;3", "c=a,b", "c=0,0;1,0;1,1&n=4,4", "c=0,0;1,0;1,1&n=4,4,0", "c=0,0;1,0;1,1&k=cr", "c=0,0;1,0;1,1&f=1,1", "c=1,NaN;2,3"]) {
    assert.equal(decodeQuestion(new URLSearchParams(query)), null, query);
  }
});
