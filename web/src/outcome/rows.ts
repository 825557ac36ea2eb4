// The rows of the table of measures: ours first, then whatever else the outcome holds.
import type { Outcome } from '../api';
import { text } from '../text';

export interface Row { label: string; value: string; amount: number | null; noise?: boolean; note?: string }
/** A displacement below this is within what a nipple moves by itself (Scurr 2015). */
export const noise_mm = 5;
const t = text.result;

const row = (label: string, amount: unknown, unit: string, digits = 1, noise = false): Row => ({
  label, amount: typeof amount === 'number' ? amount : null,
  value: typeof amount === 'number' && Number.isFinite(amount) ? `${amount.toFixed(digits)} ${unit}` : '–', noise,
});

export function rowsOf(o: Outcome): Row[] {
  const rows = [
    row(t.excised, o.excised_cm3, 'cm³'), row(t.share, o.excised_percent, '%'),
    row(t.volumeLeft, o.breast_volume_cm3.L, 'cm³', 0), row(t.volumeRight, o.breast_volume_cm3.R, 'cm³', 0),
    row(t.skin, o.resection_to_skin_mm, 'mm'), row(t.chest, o.resection_to_chest_mm, 'mm'),
    row(t.woundFinal, 100 * o.wound_volume_ratio_final, '%', 0),
    row(t.maxMove, o.max_displacement_upright_mm, 'mm', 1, o.max_displacement_upright_mm < noise_mm),
    row(t.meanMove, o.mean_displacement_upright_mm, 'mm', 1, o.mean_displacement_upright_mm < noise_mm),
  ];
  return rows.concat(extra(o.metrics));
}

/** Metrics of later versions: {name: number} or {name: {value, unit, label, source, noise_floor}}. */
function extra(metrics: unknown): Row[] {
  if (typeof metrics !== 'object' || metrics === null) return [];
  return Object.entries(metrics).flatMap(([name, m]): Row[] => {
    const words = name.replace(/_/g, ' ');
    if (typeof m === 'number') return [row(words, m, '')];
    if (typeof m !== 'object' || m === null) return [];
    const entry = m as { value?: unknown; unit?: string; label?: string; source?: string; noise_floor?: number };
    if (typeof entry.value !== 'number') return [];
    const small = typeof entry.noise_floor === 'number' && Math.abs(entry.value) < entry.noise_floor;
    return [{ ...row(entry.label ?? words, entry.value, entry.unit ?? '', 1, small), note: entry.source }];
  });
}
