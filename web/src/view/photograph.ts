// The patient's own skin: her photographed scan, before and as predicted. Shown only when asked for.
import { BufferAttribute, BufferGeometry, DoubleSide, Mesh, MeshStandardMaterial, SRGBColorSpace, Texture } from 'three';
import type { Bundle } from '../bundle';
import { clay } from './colours';

/** Triangles with a photograph first, then those without. */
export function parted(triangles: Uint32Array, corners: Float32Array): { index: Uint32Array; pictured: number } {
  const has = (t: number): boolean => [0, 1, 2].every((c) => Number.isFinite(corners[2 * triangles[3 * t + c]]));
  const count = triangles.length / 3, order = [...Array(count).keys()].sort((a, b) => Number(has(b)) - Number(has(a)));
  const index = new Uint32Array(triangles.length);
  order.forEach((t, i) => index.set(triangles.subarray(3 * t, 3 * t + 3), 3 * i));
  return { index, pictured: order.filter(has).length };
}

export async function photographs(bundle: Bundle<unknown>): Promise<{ before: Mesh; after: Mesh; dispose(): void }> {
  const jpeg = new Blob([bundle.u8('jpeg').slice()], { type: 'image/jpeg' });
  const texture = new Texture(await createImageBitmap(jpeg, { imageOrientation: 'flipY' }));
  texture.flipY = false; // the bitmap is turned already
  texture.colorSpace = SRGBColorSpace;
  texture.needsUpdate = true;
  const corners = bundle.f32('corners'), { index, pictured } = parted(bundle.u32('triangles'), corners);
  const uv = new BufferAttribute(Float32Array.from(corners, (v) => (Number.isFinite(v) ? v : 0)), 2);
  const materials = [new MeshStandardMaterial({ map: texture, roughness: 0.75, side: DoubleSide }),
    new MeshStandardMaterial({ color: clay, roughness: 0.75, side: DoubleSide })];
  const skin = (when: string): Mesh => {
    const geometry = new BufferGeometry();
    geometry.setIndex(new BufferAttribute(index, 1));
    geometry.setAttribute('position', new BufferAttribute(bundle.f32(`points.${when}`), 3));
    geometry.setAttribute('uv', uv);
    geometry.addGroup(0, 3 * pictured, 0);
    geometry.addGroup(3 * pictured, index.length - 3 * pictured, 1);
    geometry.computeVertexNormals();
    return new Mesh(geometry, materials);
  };
  const before = skin('before'), after = skin('after');
  return {
    before, after,
    dispose() {
      before.geometry.dispose(); after.geometry.dispose(); texture.dispose();
      materials.forEach((m) => m.dispose());
    },
  };
}
