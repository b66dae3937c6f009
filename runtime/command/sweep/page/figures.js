'use strict';
// Numbers as text.

const superscripts = '⁰¹²³⁴⁵⁶⁷⁸⁹';

function powerOfTen(exponent) {
  const digits = [...String(Math.abs(exponent))].map((digit) => superscripts[digit]).join('');
  return '10' + (exponent < 0 ? '⁻' : '') + digits;
}

/** Three significant digits: "0.0123", "4.56×10⁻⁷". */
function figure(value) {
  if (value === 0) return '0';
  const size = Math.abs(value);
  if (size >= 1e-3 && size < 1e5) return String(Number(value.toPrecision(3)));
  const [digits, exponent] = value.toExponential(2).split('e');
  return Number(digits) + '×' + powerOfTen(Number(exponent));
}

/** Seconds with a prefix: "12.3 µs". */
function duration(seconds) {
  const [unit, size] = [['s', 1], ['ms', 1e-3], ['µs', 1e-6], ['ns', 1e-9]].find(([, s]) => seconds >= 0.9995 * s) ||
    ['ns', 1e-9];
  return Number((seconds / size).toPrecision(3)) + ' ' + unit;
}

function withUnit(value, unit) {
  return figure(value) + (unit ? ' ' + unit : '');
}

/** An error's text; what can't be told from zero is said so. */
function errorText(value, unit, noError) {
  return value < noError ? 'none (< ' + powerOfTen(Math.round(Math.log10(noError))) + ')' : withUnit(value, unit);
}

