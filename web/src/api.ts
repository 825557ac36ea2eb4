// Everything the page asks of the server, with its types.
import { readBundle, type Bundle } from './bundle';

export type Side = 'L' | 'R';
export type Point = [number, number, number];
export type StageState = 'fresh' | 'stale' | 'failed' | 'missing';

export interface Stage {
  name: string; letter: string; title: string; state: StageState; reason: string;
  seconds: number; warnings: string[];
}
/** A cosmetic index before and after, with what such a measurement repeats to. */
export interface Metric {
  key: string; name: string; unit: string; group: string; before: number | null; after: number | null; change: number | null;
  before_range: [number, number] | null; after_range: [number, number] | null;
  below_noise: boolean; noise_floor: number; noise_source: string; reference: string; source: string;
}
export interface Range { low: number; high: number }
/** What the doubt about the chest wall does to numbers of the outcome. */
export interface WallRange {
  moved_mm: number; failed: Record<string, string>; breast_volume_cm3: Record<Side, Range>;
  excised_cm3: Range; excised_percent: Range; resection_to_chest_mm: Range;
  max_displacement_upright_mm: Range; mean_displacement_upright_mm: Range;
}
export interface Outcome {
  excised_cm3: number; excised_percent: number; operated_side: Side;
  breast_volume_cm3: Record<Side, number>;
  resection_to_skin_mm: number; resection_to_chest_mm: number;
  wound_volume_ratio_final: number;
  max_displacement_upright_mm: number; mean_displacement_upright_mm: number;
  min_jacobian: number; warnings: string[];
  cosmetics?: { metrics?: Metric[] };
  wall_range?: WallRange | null;
  scan_only?: { breast_volume_doubt_cm3?: Record<Side, number> };
  discretisation_error?: { percent?: number; [key: string]: unknown };
  [key: string]: unknown;
}
export interface CaseSummary {
  id: string; patient: string; stages: Stage[]; parameters: Record<string, string>;
  inputs: string[]; plan: string; plan_name: string; side: Side | null; outcome: Outcome | null;
  outcome_fresh?: boolean; broken?: boolean; photograph?: boolean;
}
/** Nothing but a surface scan is known: captured standing, with an estimated chest wall. */
export const isScanOnly = (s: CaseSummary): boolean => !s.inputs.includes('image') && !s.inputs.includes('labels');
export interface Job {
  id: string; case: string; kind: 'create' | 'run';
  state: 'queued' | 'running' | 'done' | 'failed' | 'cancelled';
  step: number; steps: number; created_s: number; started_s: number; ended_s: number;
  exit_code: number; message: string;
  progress: { stage: string; fraction: number; text: string; finished: string[] };
}
/** A plan as its file has it (docs/user/plan.md); keys that are not ours stay. */
export interface Plan {
  operated_side: Side; frame: 'prone' | 'supine'; coordinates?: string; quadrant?: string; name?: string;
  midline_x_mm?: number;
  tumour: { centre_lps_mm: Point; equivalent_radius_mm: number };
  planned_margin_mm: number; clearance_mm?: number;
  resection?: {
    shape?: string; radius_mm?: number; axis_towards_skin_lps?: Point; outline_lps_mm?: Point[];
    segment?: { apex_lps_mm: Point; angle_deg?: number; from_mm?: number; to_mm?: number };
  };
  incision?: { kind: string };
  incisions_lps_mm?: Point[][];
  [key: string]: unknown;
}
export interface Session {
  proof: string; abilities: { dicom: boolean; scan: boolean; scan_only: boolean; tumour: boolean; report: boolean };
  healing_presets: string[]; notice: string;
}
/** What `sanatrix inspect --json` says about images. */
export interface Series {
  series: number; series_number: number; modality: string; weighting: string; plane: string; patient_position: string; size: number[]; spacing_mm: number[];
  chosen: boolean; not_chosen_because?: string; warnings: string[];
}
export type ImageContents = { kind: 'DICOM'; series: Series[]; nothing_chosen?: string } | { kind: 'image file'; size: number[]; spacing_mm: number[] };
export interface ResultFile { stage: string; file: string; bytes: number }
export interface Tumour { radius_mm: number; centre: Record<string, Point> }
export interface SceneHead {
  captured: 'image' | 'scan'; poses: string[]; groups: { name: string; first: number; count: number }[];
  midline_x_mm: number; nipple: Record<Side, Record<string, Point>>; tumour?: Tumour;
}
export interface PreviewHead {
  excised_cm3: number; excised_g: number; excised_percent: number; breast_cm3: number;
  to_skin_mm: number; to_chest_mm: number; quadrant: string; clock_hour: number;
  from_nipple_mm: number; warnings: string[]; tumour: Tumour;
}
export interface HealingHead {
  species: { key: string; label: string; healthy: number }[]; days: number[];
  history: { day: number[]; wound_volume_ratio: number[]; max_displacement_mm: number[] };
}
export interface VolumeHead { size: Point; spacing_mm: Point; origin_mm: Point; greyscale: boolean }

/** What went wrong and what to do, in the server's words. */
export class Refusal extends Error {
  constructor(readonly status: number, message: string, readonly hint: string) { super(message); }
}

let proof = '';

async function ask(method: string, path: string, body?: BodyInit, type = 'application/json'): Promise<Response> {
  let answer: Response;
  try {
    answer = await fetch(path, {
      method, body,
      headers: method === 'GET' ? {} : { 'X-Sanatrix-Proof': proof, 'Content-Type': type },
    });
  } catch {
    throw new Refusal(0, 'the planner does not answer', 'is sanatrix serve still running?');
  }
  if (!answer.ok) {
    const told = await answer.json().catch(() => ({}));
    throw new Refusal(answer.status, told.what ?? answer.statusText, told.hint ?? '');
  }
  return answer;
}
const get = async <T>(path: string): Promise<T> => (await ask('GET', path)).json();
const post = async <T>(path: string, body: unknown = {}): Promise<T> =>
  (await ask('POST', path, JSON.stringify(body))).json();
const bundle = async <T>(answer: Promise<Response>): Promise<Bundle<T>> =>
  readBundle<T>(await (await answer).arrayBuffer());
const at = (id: string, rest = ''): string => `/api/cases/${encodeURIComponent(id)}${rest}`;

export const api = {
  async session(): Promise<Session> {
    const session = await get<Session>('/api/session');
    proof = session.proof;
    return session;
  },
  cases: async () => (await get<{ cases: CaseSummary[] }>('/api/cases')).cases,
  case: (id: string) => get<CaseSummary>(at(id)),
  create: (wish: object) => post<{ case: string; job: string }>('/api/cases', wish),
  remove: (id: string) => ask('DELETE', at(id)),
  copy: (id: string, name: string) => post<{ case: string }>(at(id, '/copies'), { name }),
  run: (id: string, wish: object) => post<{ job: string }>(at(id, '/run'), wish),
  scene: (id: string) => bundle<SceneHead>(ask('GET', at(id, '/scene'))),
  healing: (id: string) => bundle<HealingHead>(ask('GET', at(id, '/healing'))),
  photograph: (id: string) => bundle<unknown>(ask('GET', at(id, '/photograph'))),
  name: (id: string, name: string) => post(at(id, '/name'), { name }),
  volume: (id: string) => bundle<VolumeHead>(ask('GET', at(id, '/volume'))),
  plan: (id: string) => get<{ plan: Plan | null; marked_tumour: null |
    { centre_lps_mm: Point; equivalent_radius_mm: number; side: Side } }>(at(id, '/plan')),
  preview: (id: string, plan: Plan, live: boolean) =>
    bundle<PreviewHead>(ask('POST', at(id, `/preview?detail=${live ? 'live' : 'full'}`), JSON.stringify(plan))),
  incision: async (id: string, kind: string, plan: Plan) =>
    (await post<{ line_mm: Point[] }>(at(id, `/incisions/${kind}`), plan)).line_mm,
  carry: async (id: string, p: Point, from: string, to: string) =>
    (await get<{ point_mm: Point }>(at(id, `/carry?from=${from}&to=${to}&x=${p[0]}&y=${p[1]}&z=${p[2]}`))).point_mm,
  files: async (id: string) => (await get<{ files: ResultFile[] }>(at(id, '/files'))).files,
  fileAddress: (id: string, stage: string, file: string) => at(id, `/files/${stage}/${file}`),
  jobs: async () => (await get<{ jobs: Job[] }>('/api/jobs')).jobs,
  cancel: (job: string) => post(`/api/jobs/${job}/cancel`),
  resume: (job: string) => post(`/api/jobs/${job}/resume`),
  async upload(name: string, content: Blob, batch = ''): Promise<string> {
    const query = `name=${encodeURIComponent(name)}${batch ? `&batch=${batch}` : ''}`;
    const answer = await ask('POST', `/api/uploads?${query}`, content, 'application/octet-stream');
    return (await answer.json()).upload;
  },
  series: (upload: string) => get<ImageContents>(`/api/uploads/${upload}/series`),
};

/** Calls `hear` with the newest jobs whenever one changes; the browser reconnects by itself. */
export function listen(hear: (jobs: Job[]) => void, changed: (stamps: Record<string, string>) => void, lost: (isLost: boolean) => void): EventSource {
  const source = new EventSource('/api/events');
  source.addEventListener('jobs', (event) => hear(JSON.parse((event as MessageEvent).data).jobs));
  source.addEventListener('cases', (event) => changed(JSON.parse((event as MessageEvent).data).cases));
  source.addEventListener('open', () => lost(false));
  source.addEventListener('error', () => lost(true));
  return source;
}
