import { expect, test } from 'vitest';
import { letterOf, Orbit } from './camera';
import { viridisAt } from './colours';
import { along, distances, mixed } from './pose';
import { niceTop } from './scale';

test('from the front the patient’s left is on the right hand of the picture, and so from everywhere', () => {
  const orbit = new Orbit(() => undefined);
  orbit.view('front');
  expect(orbit.letters()).toEqual({ right: 'L', left: 'R', top: 'S', bottom: 'I' });
  orbit.view('left');
  expect(orbit.letters()).toEqual({ right: 'P', left: 'A', top: 'S', bottom: 'I' });
  orbit.view('back');
  expect(orbit.letters().right).toBe('R');
  orbit.view('below'); // the radiologist's axial view
  expect(orbit.letters()).toEqual({ right: 'L', left: 'R', top: 'A', bottom: 'P' });
  expect(letterOf(0, -1, 0.2)).toBe('A');
});

test('a slider over poses ends exactly in the poses', () => {
  expect(along(['a', 'b', 'c'], 2)).toEqual({ from: 'b', to: 'c', t: 1 });
  const points: Record<string, Float32Array> = { a: new Float32Array([0, 0, 0]), b: new Float32Array([2, 4, 6]) };
  const into = new Float32Array(3);
  mixed(into, (name) => points[name], { from: 'a', to: 'b', t: 0.5 });
  expect([...into]).toEqual([1, 2, 3]);
  expect(distances(points.a, new Float32Array([3, 4, 0]))[0]).toBe(5);
});

test('the colour of nothing is not a colour of the scale', () => {
  expect(viridisAt(NaN)).toEqual([0.6, 0.6, 0.6]);
  expect(viridisAt(2)).toEqual(viridisAt(1));
});

test('scales end at round numbers', () => {
  expect([1.13, 4.2, 5.3, 0.57, 0.07, 20].map(niceTop)).toEqual([1.5, 5, 6, 0.6, 0.08, 20]);
});
