import { expect, test } from 'vitest';
import type { Plan } from '../api';
import { fromMarkups, isMarkups, toMarkups } from './markups';

const plan: Plan = {
  operated_side: 'R', frame: 'prone', tumour: { centre_lps_mm: [-80, -30, 12], equivalent_radius_mm: 6.5 }, planned_margin_mm: 8,
  resection: { outline_lps_mm: [[-90, -60, 0], [-70, -60, 0], [-80, -60, 30]] }, incision: { kind: 'free' },
  incisions_lps_mm: [[[-90, -61, 5], [-70, -61, 5]]],
};

test('a plan written as markups and read again is the same surgery', () => {
  const again = fromMarkups(JSON.parse(JSON.stringify(toMarkups(plan))), null, 0);
  expect(JSON.parse(JSON.stringify(again))).toEqual(JSON.parse(JSON.stringify(plan)));
});

test('a segment keeps its tip and its numbers', () => {
  const wedge: Plan = { ...plan, resection: { segment: { apex_lps_mm: [-70, -90, 4], angle_deg: 52.5, to_mm: 61 } } };
  expect(fromMarkups(JSON.parse(JSON.stringify(toMarkups(wedge))), null, 0).resection).toEqual(wedge.resection);
});

test('RAS is turned into LPS, so that left stays left', () => {
  const file = { markups: [{ type: 'Fiducial', name: 'T', coordinateSystem: 'RAS', controlPoints: [{ position: [-70, 20, 5] as [number, number, number] }] }] };
  const read = fromMarkups(file, plan, 0);
  expect(read.tumour.centre_lps_mm).toEqual([70, -20, 5]);
  expect(read.operated_side).toBe('L');
  expect(read.incisions_lps_mm).toBeUndefined();
});

test('what cannot be meant is refused with a sentence', () => {
  const point = { position: [1, 2, 3] as [number, number, number] };
  expect(() => fromMarkups({ markups: [{ type: 'Fiducial', coordinateSystem: 'IJK', controlPoints: [point] }] }, null, 0)).toThrow('IJK');
  expect(() => fromMarkups({ markups: [{ type: 'Fiducial', coordinateUnits: 'm', controlPoints: [point] }] }, null, 0)).toThrow('millimetres');
  expect(() => fromMarkups({ markups: [] }, null, 0)).toThrow('no point');
  expect(isMarkups({ operated_side: 'L' })).toBe(false);
});
