import { expect, test } from 'vitest';
import { readBundle } from './bundle';

function bundleOf(head: object, data: Uint8Array): ArrayBuffer {
  let text = JSON.stringify(head);
  while (text.length % 8) text += ' ';
  const bytes = new Uint8Array(8 + text.length + data.length);
  bytes.set(new TextEncoder().encode('SNX1'));
  new DataView(bytes.buffer).setUint32(4, text.length, true);
  bytes.set(new TextEncoder().encode(text), 8);
  bytes.set(data, 8 + text.length);
  return bytes.buffer;
}

test('arrays are found by name, with their type', () => {
  const data = new Uint8Array(16);
  new Float32Array(data.buffer, 0, 2).set([1.5, -2]);
  new Uint32Array(data.buffer, 8, 1).set([7]);
  const bundle = readBundle<{ days: number }>(bundleOf({ days: 90, arrays: { a: { type: 'f32', offset: 0, count: 2 }, b: { type: 'u32', offset: 8, count: 1 } } }, data));
  expect(bundle.head.days).toBe(90);
  expect([...bundle.f32('a')]).toEqual([1.5, -2]);
  expect([...bundle.u32('b')]).toEqual([7]);
  expect(bundle.has('c')).toBe(false);
  expect(() => bundle.u8('a')).toThrow('u8 "a"');
});

test('something else is refused', () => {
  expect(() => readBundle(new ArrayBuffer(16))).toThrow('not a bundle');
});
