import { expect, test } from 'vitest';
import type { Outcome } from '../api';
import { rowsOf } from './rows';

const outcome = {
  excised_cm3: 39.6, excised_percent: 9.36, operated_side: 'L', breast_volume_cm3: { L: 423, R: 436 },
  resection_to_skin_mm: 5, resection_to_chest_mm: 5, wound_volume_ratio_final: 0.92,
  max_displacement_upright_mm: 1.1, mean_displacement_upright_mm: 0.4, min_jacobian: 0.4, warnings: [],
} as Outcome;

test('a displacement within what a nipple moves by itself is marked as noise', () => {
  const noisy = rowsOf(outcome).filter((r) => r.noise).length;
  expect(noisy).toBe(2);
  expect(rowsOf({ ...outcome, max_displacement_upright_mm: 12 }).filter((r) => r.noise).length).toBe(1);
});

test('metrics of later versions appear without being known, and odd ones are left out', () => {
  const rows = rowsOf({ ...outcome, metrics: { bra_mm: 12.5, pbra: { value: 3, unit: '%', label: 'pBRA' }, broken: { value: 'x' } } });
  expect(rows.map((r) => r.label)).toContain('bra mm');
  expect(rows.find((r) => r.label === 'pBRA')?.value).toBe('3.0 %');
  expect(rows.some((r) => r.label === 'broken')).toBe(false);
});

test('a missing number is a dash, never zero', () => {
  expect(rowsOf({ ...outcome, resection_to_skin_mm: undefined as unknown as number }).some((r) => r.value === '–')).toBe(true);
});
