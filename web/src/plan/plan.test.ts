import { expect, test } from 'vitest';
import * as draft from './draft';
import { History } from './history';

const plan = draft.newPlan('L', [90, -30, 10], 6, 'supine');

test('a cylinder that is tumour plus margin stays that when either changes', () => {
  const given = { ...plan, resection: { radius_mm: 16, axis_towards_skin_lps: [0, -1, 0] as [number, number, number] } };
  expect(draft.radiusOf(draft.withMargin(given, 15))).toBe(21);
  expect(draft.withMargin(given, 15).resection?.axis_towards_skin_lps).toEqual([0, -1, 0]);
  expect(draft.radiusOf(draft.withMargin(draft.withRadius(plan, 30), 15))).toBe(30);
});

test('the excision is never smaller than the tumour', () => {
  expect(draft.radiusOf(draft.withRadius(plan, 3))).toBe(6);
  expect(draft.radiusOf(draft.withTumourRadius(draft.withRadius(plan, 30), 40))).toBe(40);
});

test('a moved tumour leaves axis, outline and drawn incision behind', () => {
  const drawn = draft.withIncision(draft.withShape(plan, 'free', [[0, 0, 0], [1, 0, 0], [0, 0, 1]]), 'free', [[0, 0, 0], [1, 0, 0]]);
  const moved = draft.withTumourAt(drawn, [-80, -30, 0], 'R');
  expect(moved.operated_side).toBe('R');
  expect(draft.shapeOf(moved)).toBe('cylinder');
  expect(draft.incisionOf(moved)).toBe('over');
});

test('a segment stays with its nipple, without the numbers of the old place', () => {
  const wedge = draft.withSegment(draft.withShape(plan, 'segment', [[80, -90, 0]]), { angle_deg: 70 });
  expect(draft.shapeOf(wedge)).toBe('segment');
  expect(draft.sameSurgery(wedge, draft.withSegment(wedge, { angle_deg: 60 }))).toBe(false);
  expect(draft.withTumourAt(wedge, [100, -30, 20], 'L').resection?.segment).toEqual({ apex_lps_mm: [80, -90, 0] });
  expect(draft.shapeOf(draft.withTumourAt(wedge, [-90, -30, 0], 'R'))).toBe('cylinder');
  expect(draft.withShape(wedge, 'free', [[0, 0, 0], [1, 0, 0], [0, 0, 1]]).resection?.segment).toBeUndefined();
});

test('keys that are not ours stay', () => {
  const theirs = { ...plan, patient_note: { by: 'them' } };
  expect(draft.withMargin(theirs, 12).patient_note).toEqual({ by: 'them' });
});

test('a name is not another surgery, a margin is', () => {
  expect(draft.sameSurgery({ ...plan, name: 'B' }, plan)).toBe(true);
  expect(draft.sameSurgery(draft.withMargin(plan, 12), plan)).toBe(false);
});

test('undo takes back one gesture, not every tick of a slider', () => {
  const h = new History(0);
  h.push(1); h.push(2, true); h.push(3, true);
  h.push(10);
  expect(h.undo()).toBe(3);
  expect(h.undo()).toBe(0);
  expect(h.canUndo).toBe(false);
  expect(h.redo()).toBe(3);
  h.push(5);
  expect(h.canRedo).toBe(false);
});
