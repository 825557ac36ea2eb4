// What is being drawn on the skin, point by point; it moves with the body from pose to pose.
import { BufferAttribute, BufferGeometry, Group, Line, LineBasicMaterial, Points, PointsMaterial } from 'three';
import type { Body, Pick } from './body';
import * as colours from './colours';

export class Drawing {
  readonly group = new Group();
  private readonly geometry = new BufferGeometry();
  private picks: Pick[] = [];

  constructor(private readonly body: Body) {
    const dots = new Points(this.geometry, new PointsMaterial({ color: colours.incision, size: 9, sizeAttenuation: false, depthTest: false, transparent: true }));
    const line = new Line(this.geometry, new LineBasicMaterial({ color: colours.incision, depthTest: false, transparent: true }));
    dots.renderOrder = line.renderOrder = 6;
    dots.frustumCulled = line.frustumCulled = false;
    this.group.add(line, dots);
  }
  /** `closed`: back to the first point. */
  show(picks: Pick[], closed: boolean): void {
    this.picks = closed && picks.length > 2 ? [...picks, picks[0]] : picks;
    this.place();
  }
  place(): void {
    const { from, to, t } = this.body.pose, flat = this.picks.flatMap((pick) => {
      const a = this.body.placeIn(pick, from), b = this.body.placeIn(pick, to);
      return a.map((x, c) => x + t * (b[c] - x));
    });
    this.geometry.setAttribute('position', new BufferAttribute(new Float32Array(flat), 3));
  }
  dispose(): void { this.geometry.dispose(); }
}
