/** A fill of a list with what its pictures, its facts and its file need. */

import type { FillLine } from "./api.ts";
import type { Group } from "three";
import { type DrawnNet, makeFillFigure } from "./figure.ts";
import type { GalleryItem } from "./gallery.ts";
import { formatObj } from "./meshfile.ts";
import { formatCompact, formatPlural } from "./numbers.ts";
import type { CornerKind } from "./permalink.ts";
import { listIrregular, makeNet } from "./quadnet.ts";
import type { Palette } from "./theme.ts";
import { drawThumbnail, flatten } from "./thumbnail.ts";
import type { Point } from "./vectors.ts";

export class FillItem implements DrawnNet {
  readonly net;
  readonly points: readonly Point[];
  readonly asked: ReadonlyMap<number, number>;
  /** Valences of its irregular vertices inside, each as often as it occurs. */
  readonly valences: readonly number[];

  constructor(
    readonly line: FillLine,
    readonly rank: number,
    kinds: readonly CornerKind[],
  ) {
    if (!line.placed) throw new Error("the service did not say where the fill's vertices lie");
    this.points = line.placed;
    this.net = makeNet(line.quads, line.n_vertices);
    const asked = new Map<number, number>();
    for (const side of line.sides) for (const v of side) asked.set(v, 2);
    line.sides.forEach((side, i) => asked.set(side[0]!, kinds[i] === "reflex" ? 3 : 1));
    this.asked = asked;
    this.valences = listIrregular(this.net, asked)
      .filter((v) => !v.border)
      .map((v) => v.valence)
      .sort((a, b) => a - b);
  }

  makeFigure(palette: Palette, strands: boolean): Group {
    return makeFillFigure(this, palette, strands);
  }

  /** As the gallery shows it, seen from a direction. */
  describe(normal: Point, up: Point): GalleryItem {
    const valences = this.valences.length ? this.valences.join("·") : "regular";
    const seen = this.line.frequency ? `${formatCompact(this.line.frequency)}×` : this.line.origin;
    return {
      picture: drawThumbnail({ net: this.net, places: flatten(this.points, normal, up), asked: this.asked }),
      title: String(this.rank),
      detail: `${valences}  ${seen}`,
      label: [
        `fill ${this.rank}`,
        formatPlural(this.line.quads.length, "quad"),
        this.valences.length ? `valences ${this.valences.join(", ")}` : "regular inside",
        this.line.frequency ? `seen ${formatPlural(this.line.frequency, "time")}` : this.line.origin,
      ].join(", "),
    };
  }

  formatObj(): string {
    const remarks = [`patterndb fill, pattern ${this.line.pattern}, ${this.line.origin}`];
    return formatObj({ points: this.points, faces: this.line.quads }, remarks);
  }
}
