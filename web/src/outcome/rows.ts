// The rows of the table of measures: what was done, then the cosmetic indices before and after.
import type { Metric, Outcome, Range, Side } from '../api';
import { capital, text } from '../text';

export interface Row { label: string; before?: string; value: string; range?: string; noise?: boolean; note?: string; first?: boolean }
/** A displacement below this is within what a nipple moves by itself (Scurr 2015). */
export const noise_mm = 5;
/** What a surgeon asks first; the rest stands below a click. */
const first = ['rms_asymmetry_mm', 'retraction_mm', 'bra_mm', 'unr_mm', 'nipple_moved_mm', 'lbc_mm', 'volume_asymmetry_pct'];
const t = text.result;

const shown = (amount: unknown, unit: string, digits = 1): string =>
  (typeof amount === 'number' && Number.isFinite(amount) ? `${amount.toFixed(digits).replace('-', '−')} ${unit}`.trim() : '–');
const row = (label: string, amount: unknown, unit: string, digits = 1, noise = false): Row =>
  ({ label, value: shown(amount, unit, digits), noise, first: true });

export function rowsOf(o: Outcome): Row[] {
  const mesh = (o.discretisation_error as { max_displacement_upright_mm?: number } | undefined)?.max_displacement_upright_mm;
  const most = row(t.maxMove, o.max_displacement_upright_mm, 'mm', 1, o.max_displacement_upright_mm < noise_mm);
  if (typeof mesh === 'number') Object.assign(most, { range: `± ${mesh.toFixed(1)}`, note: t.meshError });
  const wall = o.wall_range ?? null;
  const withWall = (r: Row, range: Range | undefined, digits = 1): Row => {
    if (!range) return r;
    const [low, high] = [range.low, range.high].map((v) => shown(v, '', digits));
    return { ...r, range: [r.range, low === high ? '' : `${low} … ${high}`].filter(Boolean).join('; ') || undefined,
      note: [r.note, t.wallError].filter(Boolean).join('. ') };
  };
  const breast = (label: string, side: Side): Row => {
    const volume = o.breast_volume_cm3[side], doubt = o.scan_only?.breast_volume_doubt_cm3?.[side];
    const around = typeof doubt === 'number' ? { low: volume - doubt, high: volume + doubt } : undefined;
    return withWall(row(label, volume, 'cm³', 0), wall?.breast_volume_cm3[side] ?? around, 0);
  };
  return [
    withWall(row(t.excised, o.excised_cm3, 'cm³'), wall?.excised_cm3), withWall(row(t.share, o.excised_percent, '%'), wall?.excised_percent),
    breast(t.volumeLeft, 'L'), breast(t.volumeRight, 'R'),
    row(t.skin, o.resection_to_skin_mm, 'mm'), withWall(row(t.chest, o.resection_to_chest_mm, 'mm'), wall?.resection_to_chest_mm),
    row(t.woundFinal, 100 * o.wound_volume_ratio_final, '%', 0),
    withWall(most, wall?.max_displacement_upright_mm),
    withWall(row(t.meanMove, o.mean_displacement_upright_mm, 'mm', 1, o.mean_displacement_upright_mm < noise_mm), wall?.mean_displacement_upright_mm),
    ...(o.cosmetics?.metrics ?? []).filter((m) => m.key !== 'excised_pct').map(index)
      .sort((a, b) => Number(b.first) - Number(a.first)),
  ];
}

function index(m: Metric): Row {
  const digits = m.unit === '' ? 2 : 1, after = m.after ?? m.change;
  const range = m.after !== null ? rangeOf(m.after_range) : null;
  return {
    label: capital(m.name), first: first.includes(m.key), noise: m.below_noise,
    before: m.before === null ? '' : shown(m.before, m.unit, digits), value: shown(after, m.unit, digits),
    range: range ? `${range.map((v) => shown(v, '', digits)).join(' … ')}` : undefined,
    note: [m.source, m.reference, m.noise_source].filter(Boolean).join('. '),
  };
}
function rangeOf(range: unknown): [number, number] | null {
  const r = range as { p05?: unknown; p95?: unknown } | null;
  return r && typeof r.p05 === 'number' && typeof r.p95 === 'number' ? [r.p05, r.p95] : null;
}
