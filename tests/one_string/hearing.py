"""What an ear would make of a sound: pitch without a guess, pitch near one to a tenth of a cent, levels of partials, spectra. Of numpy alone; it
knows nothing of strings."""
import numpy as np


def cents(a, b):
    return 1200 * np.log2(a / b)


def hz_near(sound, rate, at_s, guess_hz, window_s=0.06, apart_s=0.01):
    """Of the sine near `guess_hz` about an instant: how far its phase advances in `apart_s`."""
    size, apart = round(window_s * rate), round(apart_s * rate)
    first = round(at_s * rate) - (size + apart) // 2
    if first < 0 or first + size + apart > len(sound):
        return np.nan
    window, t = np.hanning(size), np.arange(size + apart) / rate
    for _ in range(4):
        turned = sound[first:first + size + apart] * np.exp(-2j * np.pi * guess_hz * t)
        early, late = (np.sum(window * turned[k:k + size]) for k in (0, apart))
        guess_hz += np.angle(late / early) / (2 * np.pi * apart_s)
    return guess_hz


def pitch(sound, rate, at_s, lowest_hz=55.0, highest_hz=600.0, window_s=0.05, floor=1e-4):
    """Pitch about an instant by the YIN of de Cheveigne and Kawahara (JASA 111, 2002); NaN where there is silence or none."""
    size, longest, shortest = round(window_s * rate), int(rate / lowest_hz) + 2, int(rate / highest_hz)
    first = round(at_s * rate) - (size + longest) // 2
    if first < 0 or first + size + longest > len(sound):
        return np.nan
    x = sound[first:first + size + longest]
    if np.sqrt(np.mean(x ** 2)) < floor:
        return np.nan
    d = np.array([np.sum((x[:size] - x[k:k + size]) ** 2) for k in range(longest)])
    d[1:] *= np.arange(1, longest) / np.maximum(np.cumsum(d[1:]), 1e-30)
    d[0] = 1.0
    lags = [k for k in range(shortest, longest - 1) if d[k] < 0.15 and d[k] <= d[k - 1] and d[k] <= d[k + 1]]
    if not lags:
        return np.nan
    k = lags[0]
    bend = d[k - 1] - 2 * d[k] + d[k + 1]
    return rate / (k + (0.5 * (d[k - 1] - d[k + 1]) / bend if bend > 0 else 0.0))


def level(sound, rate, at_s, hz, window_s=0.2):
    """Amplitude of the sine of `hz` in a Hann window that begins at `at_s`."""
    size = round(window_s * rate)
    first = round(at_s * rate)
    window = np.hanning(size)
    part = sound[first:first + size]
    window = window[:len(part)]
    turn = np.exp(-2j * np.pi * hz * np.arange(len(part)) / rate)
    return 2 * abs(np.sum(window * part * turn)) / np.sum(window)


def spectrum(sound, rate, begin_s, end_s, highest_hz):
    """(Hz, dB below the loudest) of a stretch under a Hann window."""
    part = sound[round(begin_s * rate):round(end_s * rate)]
    size = 1 << (len(part) - 1).bit_length() + 2
    values = np.abs(np.fft.rfft(part * np.hanning(len(part)), size))
    hz = np.fft.rfftfreq(size, 1 / rate)
    kept = hz <= highest_hz
    return hz[kept], 20 * np.log10(np.maximum(values[kept], 1e-12) / values[kept].max())


def outline(sound, rate, begins_s, block_s):
    """Least and most of each block, for a picture."""
    size = round(block_s * rate)
    blocks = np.reshape(sound[:len(sound) // size * size], (-1, size))
    return {"begins_s": begins_s, "block_s": size / rate, "least": blocks.min(axis=1).tolist(), "most": blocks.max(axis=1).tolist()}
