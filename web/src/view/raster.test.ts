import { expect, test } from 'vitest';
import { draw, eyeAt, project } from './raster';

const square = (y: number): Float32Array => new Float32Array([-10, y, -10, 10, y, -10, 10, y, 10, -10, y, 10]);
const triangles = [0, 1, 2, 0, 2, 3];
const picture = (): { data: Uint8ClampedArray; width: number; height: number } => ({ data: new Uint8ClampedArray(4 * 40 * 40), width: 40, height: 40 });

test('from the front the left of the patient is on the right, her head up', () => {
  const eye = eyeAt(0, [0, 0, 0], 1);
  expect(project(eye, [5, 0, 7], 0, 40, 40).slice(0, 2)).toEqual([25, 13]);
  expect(project(eye, [0, -3, 0], 0, 40, 40)[2]).toBe(3); // anterior is nearer
  expect(project(eyeAt(90, [0, 0, 0], 1), [0, 6, 0], 0, 40, 40)[0]).toBeCloseTo(26); // from her left, her back is on the right
});

test('a square covers its own area and is lit head on; what is nearer hides what is behind', () => {
  const image = picture(), positions = new Float32Array([...square(0), ...square(-5)]);
  const lit = (i: typeof image): number => i.data.filter((_, at) => at % 4 === 3 && i.data[at] > 0).length;
  draw(image, { positions: square(0), triangles, colour: [200, 100, 0], opacity: 1 }, eyeAt(0, [0, 0, 0], 1));
  expect(Math.abs(lit(image) - 400)).toBeLessThan(45); // 20 mm x 20 mm and its rim
  expect(image.data[4 * (20 * 40 + 20)]).toBeCloseTo(200 * (0.35 + 0.65 * 0.87), -1);
  const two = picture();
  draw(two, { positions, triangles: [...triangles, ...triangles.map((v) => v + 4)], colour: [255, 255, 255], opacity: 0.5 }, eyeAt(0, [0, 0, 0], 1));
  // Blended once although two squares lie there.
  expect(two.data[4 * (20 * 40 + 20)]).toBeCloseTo(255 * 0.5 * (0.35 + 0.65 * 0.87), -1);
});
