// Where a plane cuts tetrahedra: triangles whose corners lie on edges, with values between the
// edge's ends. Marching tetrahedra; the plane is axis = value.
export interface CutPlane { positions: Float32Array; values: Float32Array }

export function cutTetrahedra(points: Float32Array, cells: Uint32Array, field: (vertex: number) => number,
  axis: 0 | 1 | 2, value: number): CutPlane {
  const positions: number[] = [], values: number[] = [];
  const side = new Float32Array(points.length / 3);
  for (let v = 0; v < side.length; ++v) side[v] = points[3 * v + axis] - value;
  const corner = (i: number, j: number): void => {
    const t = side[i] / (side[i] - side[j]);
    for (let c = 0; c < 3; ++c) positions.push(points[3 * i + c] + t * (points[3 * j + c] - points[3 * i + c]));
    values.push(field(i) + t * (field(j) - field(i)));
  };
  const above: number[] = [], below: number[] = [];
  for (let c = 0; c < cells.length; c += 4) {
    above.length = 0;
    below.length = 0;
    for (let k = 0; k < 4; ++k) (side[cells[c + k]] > 0 ? above : below).push(cells[c + k]);
    if (above.length === 0 || below.length === 0) continue;
    if (above.length === 2) {
      const [a, b] = above, [d, e] = below;
      corner(a, d); corner(a, e); corner(b, e);
      corner(a, d); corner(b, e); corner(b, d);
    } else {
      const [tip] = above.length === 1 ? above : below, base = above.length === 1 ? below : above;
      for (const v of base) corner(tip, v);
    }
  }
  return { positions: new Float32Array(positions), values: new Float32Array(values) };
}
