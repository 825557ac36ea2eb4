import { expect, test } from 'vitest';
import type { Metric, Outcome } from '../api';
import { rowsOf } from './rows';

const outcome = {
  excised_cm3: 39.6, excised_percent: 9.36, operated_side: 'L', breast_volume_cm3: { L: 423, R: 436 },
  resection_to_skin_mm: 5, resection_to_chest_mm: 5, wound_volume_ratio_final: 0.92,
  max_displacement_upright_mm: 1.1, mean_displacement_upright_mm: 0.4, min_jacobian: 0.4, warnings: [],
} as Outcome;
const bra = {
  key: 'bra_mm', name: 'BRA', unit: 'mm', group: 'nipple', before: 2.33, after: 12.41, change: 10.08, below_noise: false,
  before_range: null, after_range: { p05: 6.2, p95: 19.84 }, noise_floor: 5, noise_source: 'n', reference: 'r', source: 's',
} as unknown as Metric;

test('a displacement within what a nipple moves by itself is marked as noise', () => {
  expect(rowsOf(outcome).filter((r) => r.noise).length).toBe(2);
  expect(rowsOf({ ...outcome, max_displacement_upright_mm: 12 }).filter((r) => r.noise).length).toBe(1);
});

test('an index comes with both times, its range, and where it is from', () => {
  const row = rowsOf({ ...outcome, cosmetics: { metrics: [bra] } }).find((r) => r.label === 'BRA')!;
  expect(row).toMatchObject({ before: '2.3 mm', value: '12.4 mm', range: '6.2 … 19.8', first: true, note: 's. r. n' });
});

test('an index that is a change only shows the change, with a real minus, and no range', () => {
  const moved = { ...bra, key: 'nipple_lateral_mm', name: 'to the side', before: null, after: null, change: -3.14 };
  const row = rowsOf({ ...outcome, cosmetics: { metrics: [moved] } }).find((r) => r.label === 'To the side')!;
  expect(row).toMatchObject({ before: '', value: '−3.1 mm', range: undefined, first: false });
});

test('a missing number is a dash, never zero', () => {
  expect(rowsOf({ ...outcome, resection_to_skin_mm: undefined as unknown as number }).some((r) => r.value === '–')).toBe(true);
});

test('the doubt about the chest wall is a range of its own, and from a scan alone the volumes have one anyway', () => {
  const shown = (o: typeof outcome, label: string) => rowsOf(o).find((r) => r.label.startsWith(label))?.range;
  const range = (low: number, high: number) => ({ low, high });
  const wall_range = {
    moved_mm: 7, failed: {}, breast_volume_cm3: { L: range(466, 613), R: range(450, 600) },
    excised_cm3: range(37, 52), excised_percent: range(8, 9), resection_to_chest_mm: range(2, 16),
    max_displacement_upright_mm: range(1.26, 1.29), mean_displacement_upright_mm: range(0.29, 0.36),
  };
  expect(shown({ ...outcome, wall_range }, 'Mean skin')).toBe('0.3 … 0.4');
  const breast = rowsOf(outcome).find((r) => r.label.includes('eft'))!.label;
  expect(shown({ ...outcome, wall_range }, breast)).toBe('466 … 613');
  expect(shown({ ...outcome, wall_range }, 'Largest skin'), 'no range where no shown digit changes').toBe(undefined);
  const volume = outcome.breast_volume_cm3.L;
  const scan_only = { breast_volume_doubt_cm3: { L: 40, R: 40 } };
  expect(shown({ ...outcome, scan_only }, breast)).toBe(`${(volume - 40).toFixed(0)} … ${(volume + 40).toFixed(0)}`);
  expect(shown(outcome, breast)).toBeUndefined();
});
