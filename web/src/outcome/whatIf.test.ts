import { expect, test } from 'vitest';
import type { CaseSummary } from '../api';
import { families, sisters, spread } from './whatIf';

const made = (id: string, plan: string, parameters: Record<string, string>, moved: number): CaseSummary => ({
  id, patient: 'p', plan, parameters, outcome: { max_displacement_upright_mm: moved }, outcome_fresh: true,
} as unknown as CaseSummary);
const own = made('a', 'one', { 'mesh.preset': 'paper' }, 2);

test('only the same plan with the same settings under another model of healing is a sister', () => {
  const bad = made('b', 'one', { 'mesh.preset': 'paper', 'heal.preset': 'clinical_kader' }, 9);
  const found = sisters(own, [own, bad, made('c', 'two', bad.parameters, 5), made('d', 'one', { 'heal.preset': 'clinical_kader' }, 7)]);
  expect([...found.keys()].sort()).toEqual(['clinical_kader', 'vavourakis2016']);
  expect(found.get('clinical_kader')!.id).toBe('b');
});

test('the range covers what has been computed and counts no stale result', () => {
  const stale = { ...made('e', 'one', {}, 90), outcome_fresh: false };
  expect(spread([own, made('b', 'one', {}, 9), stale], (s) => s.outcome!.max_displacement_upright_mm))
    .toEqual({ low: 2, high: 9, models: 2 });
});

test('what-ifs stand under their plan in the list; equal plans under one model stand alone', () => {
  const bad = made('a-kader', 'one', { 'mesh.preset': 'paper', 'heal.preset': 'clinical_kader' }, 9), wide = made('c', 'two', { 'mesh.preset': 'paper' }, 5);
  const found = families([bad, wide, own, made('again', 'one', { 'mesh.preset': 'paper' }, 2)]);
  expect(found.map((f) => [f.main.id, f.others.map((o) => o.id)])).toEqual([['a', ['a-kader']], ['c', []], ['again', []]]);
});
