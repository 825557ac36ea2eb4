// One patient in one pane: skin, cut faces, tumour, excision, incision; in any pose.
import {
  BufferAttribute, BufferGeometry, Color, DoubleSide, Group, LineBasicMaterial,
  Mesh, MeshBasicMaterial, MeshStandardMaterial, NormalBlending, Ray, SphereGeometry, Vector3, LineSegments,
} from 'three';
import { Line2 } from 'three/examples/jsm/lines/Line2.js';
import { LineGeometry } from 'three/examples/jsm/lines/LineGeometry.js';
import { LineMaterial } from 'three/examples/jsm/lines/LineMaterial.js';
import { MeshBVH } from 'three-mesh-bvh';
import type { Point, PreviewHead, SceneHead, Side, Tumour } from '../api';
import type { Bundle } from '../bundle';
import * as colours from './colours';
import { mixed, type Pose } from './pose';

export interface Pick { point: Point; corners: [number, number, number]; weights: Point; inside: Vector3 }
type Cut = { bundle: Bundle<unknown>; tumour?: Tumour };

export class Body {
  readonly group = new Group();
  readonly head: SceneHead;
  /** Hears of a new pose. */
  moved: (() => void) | null = null;
  pose: Pose = { from: 'prone', to: 'prone', t: 0 };
  private readonly skin: Mesh<BufferGeometry, MeshStandardMaterial>;
  /** Writes only how far the skin is: of a skin that is seen through, one layer is drawn. */
  private readonly nearest: Mesh<BufferGeometry, MeshBasicMaterial>;
  private readonly inside: Mesh<BufferGeometry, MeshStandardMaterial>;
  private readonly tumour: Mesh;
  private readonly nipples: Record<Side, Mesh>;
  private readonly wound: Mesh<BufferGeometry, MeshStandardMaterial>;
  private readonly arrows: LineSegments;
  private lines: Line2[] = [];
  private lineLengths: number[] = [];
  private cut: Cut | null = null;
  private bvh: MeshBVH | null = null;
  private bvhIsOld = true;

  constructor(readonly bundle: Bundle<SceneHead>) {
    this.head = bundle.head;
    const triangles = bundle.u32('triangles');
    const positions = new BufferAttribute(new Float32Array(bundle.f32('points.prone').length), 3);
    const part = (isSkin: boolean, colour: number, shine: number): Mesh<BufferGeometry, MeshStandardMaterial> => {
      const geometry = new BufferGeometry();
      const chosen = this.head.groups.filter((g) => (g.name === 'skin') === isSkin);
      const index = new Uint32Array(chosen.reduce((n, g) => n + 3 * g.count, 0));
      let at = 0;
      for (const g of chosen) {
        index.set(triangles.subarray(3 * g.first, 3 * (g.first + g.count)), at);
        at += 3 * g.count;
      }
      geometry.setIndex(new BufferAttribute(index, 1));
      geometry.setAttribute('position', positions);
      const material = new MeshStandardMaterial({ color: colour, roughness: shine, metalness: 0, side: DoubleSide });
      return new Mesh(geometry, material);
    };
    this.skin = part(true, colours.clay, 0.72);
    this.inside = part(false, colours.clayInside, 0.95);
    this.nearest = new Mesh(this.skin.geometry, new MeshBasicMaterial({ colorWrite: false, transparent: true, side: DoubleSide }));
    this.tumour = new Mesh(new SphereGeometry(1, 32, 20), new MeshStandardMaterial({ color: colours.tumour, roughness: 0.5 }));
    this.wound = new Mesh(new BufferGeometry(), new MeshStandardMaterial({
      color: colours.excision, roughness: 0.6, transparent: true, opacity: 0.55, side: DoubleSide, depthWrite: false,
      blending: NormalBlending,
    }));
    this.arrows = new LineSegments(new BufferGeometry(), new LineBasicMaterial({ color: 0x1b2a33 }));
    const nipple = (): Mesh => new Mesh(new SphereGeometry(3.2, 24, 16), new MeshStandardMaterial({ color: 0xc4a698, roughness: 0.8 }));
    this.nipples = { L: nipple(), R: nipple() };
    this.group.add(this.skin, this.nearest, this.inside, this.tumour, this.wound, this.arrows, this.nipples.L, this.nipples.R);
    [this.tumour, this.wound].forEach((mesh) => { mesh.renderOrder = 2; });
    this.nearest.renderOrder = 3;
    this.setCut(bundle.has('wound.triangles') ? { bundle, tumour: this.head.tumour } : null);
    this.tumour.visible = this.head.tumour !== undefined;
    this.setPose(this.pose);
  }

  has(pose: string): boolean { return this.head.poses.includes(pose); }

  setPose(pose: Pose): void {
    this.pose = pose;
    const positions = this.skin.geometry.getAttribute('position') as BufferAttribute;
    mixed(positions.array as Float32Array, (name) => this.bundle.f32(`points.${name}`), pose);
    positions.needsUpdate = true;
    this.skin.geometry.computeVertexNormals();
    this.inside.geometry.computeVertexNormals();
    this.skin.geometry.computeBoundingSphere();
    this.inside.geometry.computeBoundingSphere();
    this.bvhIsOld = true;
    this.moved?.();
    for (const side of ['L', 'R'] as const) this.place(this.nipples[side], this.head.nipple[side]);
    this.placeCut();
  }

  /** What a plan removes, from the server; null: nothing to show. */
  showPlan(preview: Bundle<PreviewHead> | null): void {
    this.setCut(preview ? { bundle: preview, tumour: preview.head.tumour } : null);
    this.placeCut();
  }
  showSurgery(show: { tumour: boolean; excision: boolean; seeThrough: boolean; opacity?: number }): void {
    const tumour = this.cut?.tumour ?? this.head.tumour;
    this.tumour.visible = show.tumour && tumour !== undefined;
    this.wound.visible = show.excision && this.cut !== null;
    for (const line of this.lines) line.visible = show.excision;
    const material = this.skin.material;
    material.transparent = show.seeThrough;
    material.opacity = show.seeThrough ? (show.opacity ?? 0.5) : 1;
    this.inside.visible = !show.seeThrough;
    material.depthWrite = !show.seeThrough;
    this.nearest.visible = show.seeThrough;
    this.skin.renderOrder = show.seeThrough ? 4 : 0;
    material.needsUpdate = true;
  }
  /** Colours per shell vertex, or clay. */
  paint(values: Float32Array | null, colour: (value: number) => [number, number, number]): void {
    const material = this.skin.material, geometry = this.skin.geometry;
    material.vertexColors = values !== null;
    material.color = new Color(values ? 0xffffff : colours.clay);
    if (values) {
      const rgb = new Float32Array(values.length * 3);
      const c = new Color();
      values.forEach((v, i) => { c.setRGB(...colour(v), 'srgb').toArray(rgb, 3 * i); });
      geometry.setAttribute('color', new BufferAttribute(rgb, 3));
    }
    material.needsUpdate = true;
  }
  /** Arrows from one pose to another, true length times `scale`, on a thinned set of vertices. */
  showArrows(from: string | null, to = '', scale = 1): void {
    this.arrows.visible = from !== null;
    if (from === null) return;
    const a = this.bundle.f32(`points.${from}`), b = this.bundle.f32(`points.${to}`);
    const points: number[] = [];
    const breast = this.bundle.u8('breast');
    for (let i = 0; i < breast.length; i += 3) {
      if (breast[i] === 0) continue;
      for (let c = 0; c < 3; ++c) points.push(a[3 * i + c]);
      const tip = [0, 1, 2].map((c) => a[3 * i + c] + scale * (b[3 * i + c] - a[3 * i + c]));
      points.push(...tip);
      // Two barbs, a quarter as long, tell where it points.
      for (const side of [-1, 1]) {
        const d = tip.map((x, c) => x - a[3 * i + c]);
        points.push(...tip, ...tip.map((x, c) => x - 0.25 * d[c] + 0.12 * side * d[(c + 1) % 3] * (c === 2 ? -1 : 1)));
      }
    }
    this.arrows.geometry.dispose();
    this.arrows.geometry = new BufferGeometry().setAttribute('position', new BufferAttribute(new Float32Array(points), 3));
  }

  /** Builds or refits the search tree; when nobody waits for it, a click is answered at once. */
  prepare(): MeshBVH {
    if (!this.bvh) this.bvh = new MeshBVH(this.skin.geometry);
    else if (this.bvhIsOld) this.bvh.refit();
    this.bvhIsOld = false;
    return this.bvh;
  }
  pick(ray: Ray): Pick | null {
    const hit = this.prepare().raycastFirst(ray, DoubleSide);
    if (!hit?.face) return null;
    const positions = this.skin.geometry.getAttribute('position') as BufferAttribute;
    const corners: [number, number, number] = [hit.face.a, hit.face.b, hit.face.c];
    const weights = barycentric(hit.point, corners.map((i) => new Vector3().fromBufferAttribute(positions, i)));
    const inside = hit.face.normal.clone();
    if (inside.dot(ray.direction) < 0) inside.negate();
    return { point: hit.point.toArray() as Point, corners, weights, inside };
  }
  /** A function that tells a vertex field's value (three numbers a vertex) at the place of the skin
   * that is nearest to a point of a pose. */
  nearestPlace(pose: string): (p: Vector3, field: Float32Array, into: Point) => void {
    const geometry = new BufferGeometry(), positions = new BufferAttribute(this.bundle.f32(`points.${pose}`), 3);
    geometry.setAttribute('position', positions);
    geometry.setIndex((this.skin.geometry.index as BufferAttribute).clone());
    const tree = new MeshBVH(geometry), index = geometry.index!.array;
    return (p, field, into) => {
      const hit = tree.closestPointToPoint(p)!, corners = [0, 1, 2].map((c) => index[3 * hit.faceIndex + c]);
      const weights = barycentric(hit.point, corners.map((i) => new Vector3().fromBufferAttribute(positions, i)));
      for (let c = 0; c < 3; ++c) into[c] = corners.reduce((sum, v, i) => sum + weights[i] * field[3 * v + c], 0);
    };
  }
  /** The same place of the skin in another pose. */
  placeIn(pick: Pick, pose: string): Point {
    const points = this.bundle.f32(`points.${pose}`);
    return [0, 1, 2].map((c) => pick.corners.reduce((sum, v, i) => sum + pick.weights[i] * points[3 * v + c], 0)) as Point;
  }
  dispose(): void {
    this.group.traverse((o) => { if (o instanceof Mesh) o.geometry.dispose(); });
  }

  private setCut(cut: Cut | null): void {
    this.cut = cut;
    for (const line of this.lines) { this.group.remove(line); line.geometry.dispose(); }
    this.lines = [];
    this.wound.geometry.dispose();
    this.wound.geometry = new BufferGeometry();
    this.wound.visible = cut !== null;
    if (!cut) return;
    const { bundle } = cut;
    this.wound.geometry.setIndex(new BufferAttribute(bundle.u32('wound.triangles'), 1));
    this.wound.geometry.setAttribute('position', new BufferAttribute(new Float32Array(bundle.f32('wound.prone').length), 3));
    this.lineLengths = [...bundle.u32('incision.lengths')];
    this.lines = this.lineLengths.map(() => {
      // Seen through the skin: the line lies in it.
      const line = new Line2(new LineGeometry(), new LineMaterial({ color: colours.incision, linewidth: 3.5, depthTest: false, transparent: true }));
      line.renderOrder = 5;
      this.group.add(line);
      return line;
    });
  }
  private placeCut(): void {
    const tumour = this.cut?.tumour ?? this.head.tumour;
    if (tumour) {
      this.place(this.tumour, tumour.centre);
      this.tumour.scale.setScalar(tumour.radius_mm);
    }
    if (!this.cut) return;
    const { bundle } = this.cut;
    const positions = this.wound.geometry.getAttribute('position') as BufferAttribute;
    mixed(positions.array as Float32Array, (name) => bundle.f32(`wound.${name}`), this.pose);
    positions.needsUpdate = true;
    this.wound.geometry.computeVertexNormals();
    this.wound.geometry.computeBoundingSphere();
    const all = new Float32Array(bundle.f32('incision.prone').length);
    mixed(all, (name) => bundle.f32(`incision.${name}`), this.pose);
    let at = 0;
    this.lines.forEach((line, i) => {
      line.geometry.dispose();
      line.geometry = new LineGeometry();
      line.geometry.setPositions(all.subarray(at, at + 3 * this.lineLengths[i]));
      at += 3 * this.lineLengths[i];
    });
  }
  private place(mesh: Mesh, centre: Record<string, Point>): void {
    const { from, to, t } = this.pose;
    const a = centre[from], b = centre[to];
    if (a && b) mesh.position.set(...([0, 1, 2].map((c) => (1 - t) * a[c] + t * b[c]) as Point));
  }
}

function barycentric(p: Vector3, [a, b, c]: Vector3[]): Point {
  const ab = b.clone().sub(a), ac = c.clone().sub(a), n = ab.clone().cross(ac), area = n.lengthSq();
  const v = p.clone().sub(a).cross(ac).dot(n) / area, w = ab.clone().cross(p.clone().sub(a)).dot(n) / area;
  return [1 - v - w, v, w];
}
