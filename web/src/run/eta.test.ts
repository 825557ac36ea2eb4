import { expect, test } from 'vitest';
import type { Job, Stage } from '../api';
import { estimate, inWords } from './eta';

const job = (stage: string, fraction: number, finished: string[], kind: Job['kind'] = 'run'): Job => ({
  id: 'j', case: 'c', kind, state: 'running', step: kind === 'create' ? 2 : 0, steps: 1, created_s: 0, started_s: 0, ended_s: 0,
  exit_code: 0, message: '', progress: { stage, fraction, text: '', finished },
});
const stages = (fresh: string[]): Stage[] => ['image', 'segment', 'mesh', 'unload', 'supine', 'surgery', 'heal', 'upright', 'outcome'].map((name) => (
  { name, letter: '', title: '', state: fresh.includes(name) ? 'fresh' : 'missing', reason: '', seconds: name === 'heal' ? 40 : 10, warnings: [] }));
const upstream = ['image', 'segment', 'mesh', 'unload', 'supine'];

test('only what is out of date counts', () => {
  const e = estimate(job('heal', 0.5, ['surgery']), stages(upstream), 30);
  expect(e.fraction).toBeCloseTo(30 / 70, 5);
  expect(e.secondsLeft).toBeCloseTo(40, 5);
});

test('a machine twice as slow takes twice as long', () => {
  expect(estimate(job('heal', 0.5, ['surgery']), stages(upstream), 60).secondsLeft).toBeCloseTo(80, 5);
});

test('progress never runs backwards along a run', () => {
  let last = -1;
  const done: string[] = [];
  for (const name of ['surgery', 'heal', 'upright', 'outcome']) {
    for (const fraction of [0, 0.5, 1]) {
      const e = estimate(job(name, fraction, [...done]), stages(upstream), 10);
      expect(e.fraction).toBeGreaterThanOrEqual(last);
      last = e.fraction;
    }
    done.push(name);
  }
  expect(last).toBeCloseTo(1, 5);
});

test('times are told as people tell them', () => {
  expect(inWords(7)).toBe('10 s');
  expect(inWords(95)).toBe('2 min');
});
