// Plans as Slicer markups (.mrk.json, schema markups-schema-v1.0.3) and back: the tumour as a point
// whose description holds its radius, outline and incision as curves. LPS millimetres; RAS is read.
import type { Plan, Point } from '../api';

const schema = 'https://raw.githubusercontent.com/slicer/slicer/master/Modules/Loadable/Markups/Resources/Schema/markups-schema-v1.0.3.json#';

interface ControlPoint { id?: string; label?: string; description?: string; position: Point }
interface Markup { type: string; name?: string; coordinateSystem?: string; coordinateUnits?: string; controlPoints?: ControlPoint[] }
export interface Markups { '@schema'?: string; markups: Markup[] }

const markup = (type: string, name: string, points: Point[], label: string, description = ''): Markup => ({
  type, name, coordinateSystem: 'LPS', coordinateUnits: 'mm',
  controlPoints: points.map((position, i) => ({ id: String(i + 1), label: points.length > 1 ? `${label}-${i + 1}` : label, description, position })),
});

export function toMarkups(plan: Plan): Markups {
  const radius = `radius_mm=${plan.tumour.equivalent_radius_mm} margin_mm=${plan.planned_margin_mm} side=${plan.operated_side} pose=${plan.frame}`;
  const segment = plan.resection?.segment;
  const given = (s: object): string => Object.entries(s).filter(([, v]) => typeof v === 'number').map(([k, v]) => `${k}=${v}`).join(' ');
  return {
    '@schema': schema,
    markups: [
      markup('Fiducial', 'tumour', [plan.tumour.centre_lps_mm], 'tumour', radius),
      ...(plan.resection?.outline_lps_mm ? [markup('ClosedCurve', 'outline', plan.resection.outline_lps_mm, 'outline')] : []),
      ...(segment ? [markup('Fiducial', 'segment apex', [segment.apex_lps_mm], 'apex', given(segment))] : []),
      ...(plan.incisions_lps_mm ?? []).map((line, i) => markup('Curve', i ? `incision ${i + 1}` : 'incision', line, 'incision')),
    ],
  };
}

export const isMarkups = (file: unknown): file is Markups =>
  typeof file === 'object' && file !== null && Array.isArray((file as Markups).markups);

/** The markups of a file laid over a plan. Throws a sentence when the file cannot be meant. */
export function fromMarkups(file: Markups, onto: Plan | null, midline_mm: number): Plan {
  let tumour: Point | null = null, words = '', outline: Point[] | null = null, segment: Record<string, unknown> | null = null;
  const incisions: Point[][] = [];
  for (const m of file.markups) {
    if (m.coordinateUnits && m.coordinateUnits !== 'mm') throw new Error(`the markups are in ${m.coordinateUnits}; millimetres are expected`);
    const points = (m.controlPoints ?? []).map((p) => inLps(p.position, m.coordinateSystem ?? 'LPS'));
    const kind = (m.name ?? '').toLowerCase();
    if (m.type === 'Fiducial' && points.length && kind === 'segment apex') {
      const numbers = [...(m.controlPoints?.[0].description ?? '').matchAll(/(angle_deg|from_mm|to_mm)=([\d.]+)/g)];
      segment = { apex_lps_mm: points[0], ...Object.fromEntries(numbers.map(([, key, value]) => [key, Number(value)])) };
    } else if (m.type === 'Fiducial' && points.length && (kind.includes('tumo') || !tumour)) {
      tumour = points[0];
      words = m.controlPoints?.[0].description ?? '';
    } else if (m.type === 'ClosedCurve' && points.length >= 3) outline = points;
    else if ((m.type === 'Curve' || m.type === 'Line') && points.length >= 2) incisions.push(points);
  }
  const centre = tumour ?? onto?.tumour.centre_lps_mm;
  if (!centre) throw new Error('the markups hold no point for the tumour');
  const told = (key: string): string | undefined => new RegExp(`${key}=([^ ]+)`).exec(words)?.[1];
  const base: Plan = onto ?? { operated_side: 'L', frame: 'supine', tumour: { centre_lps_mm: centre, equivalent_radius_mm: 7.5 }, planned_margin_mm: 10 };
  const { incisions_lps_mm: _i, incision: _k, resection: _r, quadrant: _q, ...rest } = base;
  return {
    ...rest,
    operated_side: centre[0] > midline_mm ? 'L' : 'R',
    frame: told('pose') === 'prone' ? 'prone' : told('pose') === 'supine' ? 'supine' : base.frame,
    coordinates: undefined,
    tumour: { centre_lps_mm: centre, equivalent_radius_mm: Number(told('radius_mm')) || base.tumour.equivalent_radius_mm },
    planned_margin_mm: told('margin_mm') ? Number(told('margin_mm')) : base.planned_margin_mm,
    ...(outline ? { resection: { outline_lps_mm: outline } } : segment ? { resection: { segment } as Plan['resection'] } : {}),
    ...(incisions.length ? { incision: { kind: 'free' }, incisions_lps_mm: incisions } : {}),
  };
}

function inLps(p: Point, system: string): Point {
  if (!Array.isArray(p) || p.length !== 3 || !p.every(Number.isFinite)) throw new Error('a markup has a point that is not three numbers');
  // Older Slicer files write the number of the system: 0 is RAS, 1 is LPS.
  if (system === 'LPS' || system === '1') return p;
  if (system === 'RAS' || system === '0') return [-p[0], -p[1], p[2]];
  throw new Error(`the coordinate system "${system}" is not known; LPS and RAS are`);
}
