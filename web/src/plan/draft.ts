// Changes of a plan as the surgeon makes them; each returns a new plan. Geometry is the server's.
import type { Plan, Point, Side } from '../api';

export type Shape = 'cylinder' | 'segment' | 'free';
export type Segment = NonNullable<NonNullable<Plan['resection']>['segment']>;
export type Incision = 'over' | 'circumareolar' | 'radial' | 'inframammary' | 'free';

export function newPlan(side: Side, centre: Point, radius: number, frame: 'prone' | 'supine'): Plan {
  return {
    operated_side: side, frame, tumour: { centre_lps_mm: centre, equivalent_radius_mm: radius },
    planned_margin_mm: 10, clearance_mm: 5,
  };
}
export const radiusOf = (plan: Plan): number =>
  plan.resection?.radius_mm ?? plan.tumour.equivalent_radius_mm + plan.planned_margin_mm;
/** Does the radius follow tumour and margin? (0.1 mm: rounding in plans) */
export const isAutomatic = (plan: Plan): boolean => plan.resection?.radius_mm === undefined ||
  Math.abs(plan.resection.radius_mm - plan.tumour.equivalent_radius_mm - plan.planned_margin_mm) < 0.1;
export const shapeOf = (plan: Plan): Shape =>
  plan.resection?.outline_lps_mm ? 'free' : plan.resection?.segment ? 'segment' : 'cylinder';
export const incisionOf = (plan: Plan): Incision =>
  !plan.incisions_lps_mm?.length ? 'over' : ((plan.incision?.kind as Incision | undefined) ?? 'free');

/** Moves tumour or margin; the cylinder goes along when it followed them before. */
function withFollowing(plan: Plan, change: Partial<Plan>): Plan {
  const next: Plan = { ...plan, ...change };
  if (plan.resection?.radius_mm !== undefined && isAutomatic(plan)) {
    next.resection = { ...plan.resection, radius_mm: undefined };
  } else if (plan.resection?.radius_mm !== undefined && plan.resection.radius_mm < next.tumour.equivalent_radius_mm) {
    next.resection = { ...plan.resection, radius_mm: next.tumour.equivalent_radius_mm };
  }
  return clean(next);
}
export const withMargin = (plan: Plan, mm: number): Plan => withFollowing(plan, { planned_margin_mm: mm });
export const withTumourRadius = (plan: Plan, mm: number): Plan =>
  withFollowing(plan, { tumour: { ...plan.tumour, equivalent_radius_mm: mm } });
export const withRadius = (plan: Plan, mm: number): Plan =>
  clean({ ...plan, resection: { ...plan.resection, radius_mm: Math.max(mm, plan.tumour.equivalent_radius_mm) } });
export const withClearance = (plan: Plan, mm: number): Plan => ({ ...plan, clearance_mm: mm });

/** A new place: the old axis, outline and drawn incision belong to the old one. */
export function withTumourAt(plan: Plan, centre: Point, side: Side): Plan {
  const { incisions_lps_mm: _old, incision: _kind, quadrant: _where, ...rest } = plan;
  return clean({
    ...rest, operated_side: side, tumour: { ...plan.tumour, centre_lps_mm: centre },
    resection: {
      ...(isAutomatic(plan) ? {} : { radius_mm: plan.resection?.radius_mm }),
      // The nipple stays where it is; what was set by hand for the old place does not fit the new.
      ...(plan.resection?.segment && side === plan.operated_side ? { segment: { apex_lps_mm: plan.resection.segment.apex_lps_mm } } : {}),
    },
  });
}
/** `points`: the outline, or the nipple as the tip of a segment. */
export function withShape(plan: Plan, shape: Shape, points?: Point[]): Plan {
  const { outline_lps_mm: _o, shape: _s, segment: _g, ...rest } = plan.resection ?? {};
  if (shape === 'free') return clean({ ...plan, resection: { ...rest, outline_lps_mm: points } });
  if (shape === 'segment') return clean({ ...plan, resection: { ...rest, segment: { apex_lps_mm: points![0] } } });
  return clean({ ...plan, resection: rest });
}
/** Opening, begin and end of a segment; what is undefined follows the margin. */
export const withSegment = (plan: Plan, change: Partial<Segment>): Plan =>
  clean({ ...plan, resection: { ...plan.resection, segment: { ...plan.resection!.segment!, ...change } } });
/** What a segment without numbers of its own has, nearly: across the axis is a little less. */
export function usualSegment(plan: Plan): { angle_deg: number; from_mm: number; to_mm: number } {
  const apex = plan.resection!.segment!.apex_lps_mm, centre = plan.tumour.centre_lps_mm, r = radiusOf(plan);
  const d = Math.hypot(...apex.map((a, c) => a - centre[c]));
  return { angle_deg: (2 * Math.asin(Math.min(0.87, r / Math.max(d, 1))) * 180) / Math.PI, from_mm: Math.max(0, d - r), to_mm: d + r };
}
/** A line on the skin, and how it came about; 'over' lets the server place its usual one. */
export function withIncision(plan: Plan, kind: Incision, line?: Point[]): Plan {
  const { incisions_lps_mm: _l, incision: _k, ...rest } = plan;
  return clean(kind === 'over' || !line ? rest : { ...rest, incision: { kind }, incisions_lps_mm: [line] });
}

/** Without empty keys, so that files stay readable and equal plans are equal text. */
function clean(plan: Record<string, unknown>): Plan {
  const next = JSON.parse(JSON.stringify(plan)) as Plan;
  if (next.resection && Object.keys(next.resection).length === 0) delete next.resection;
  return next;
}
export const sameSurgery = (a: Plan | null, b: Plan | null): boolean => surgeryText(a) === surgeryText(b);
function surgeryText(plan: Plan | null): string {
  if (!plan) return '';
  const { tumour, planned_margin_mm, clearance_mm, operated_side, frame, incisions_lps_mm, resection } = plan;
  return JSON.stringify([operated_side, frame, tumour.centre_lps_mm, tumour.equivalent_radius_mm, planned_margin_mm,
    clearance_mm ?? 5, radiusOf(plan).toFixed(2), resection?.axis_towards_skin_lps ?? null, resection?.outline_lps_mm ?? null, resection?.segment ?? null,
    incisions_lps_mm?.length ? incisions_lps_mm : null]);
}
