// Presses a string and lets it go, in C#: poses in, forces and tones out. For a daemon in virtual time with a scripted device:
//   hapticd --clock virtual --device scripted
// mcs Press.cs Hapticd.cs && mono Press.exe [HOST:PORT]
using System;
using System.Globalization;
using Hapticd;

static class Press
{
    const int Ticks = 600;

    /// Beside the string, down, across it, which plucks it, and up again.
    static Pose[] Pluck()
    {
        var poses = new Pose[Ticks];
        for (int tick = 0; tick < Ticks; ++tick)
        {
            double s = (double)tick / (Ticks - 1);
            double y = 0.0153 - 0.0113 * Math.Min(1.0, 4.0 * Math.Min(s, 1.0 - s));
            double z = -0.012 + 0.024 * Math.Min(1.0, Math.Max(0.0, 2.0 * s - 0.5));
            poses[tick] = new Pose { Position = new[] { 0.0, y, z }, Quaternion = new[] { 1.0, 0.0, 0.0, 0.0 } };
        }
        return poses;
    }

    static void Play(Session session)
    {
        session.Acquire("Press");
        session.LoadScene("single_string");
        session.Subscribe(1);
        RunResult result = session.Run(Ticks, Pluck());
        double largest = 0.0;
        var state = new State();
        while (session.NextState(ref state))
        {
            float[] f = state.Tools[0].Wrench;
            largest = Math.Max(largest, Math.Sqrt((double)f[0] * f[0] + (double)f[1] * f[1] + (double)f[2] * f[2]));
        }
        var found = new Event();
        while (session.NextEvent(ref found))
        {
            if (found.Kind != EventKind.Tone) continue;
            Console.WriteLine("string {0} sounds at {1:F2} Hz after {2:F3} ms", found.StringIndex, found.Frequency, found.TimeNs * 1e-6);
        }
        Console.WriteLine("{0} ticks, largest force {1:F4} N, state hash {2}", result.Steps, largest,
                          BitConverter.ToString(result.StateHash).Replace("-", "").ToLowerInvariant());
    }

    static int Main(string[] arguments)
    {
        CultureInfo.DefaultThreadCurrentCulture = CultureInfo.InvariantCulture;
        System.Threading.Thread.CurrentThread.CurrentCulture = CultureInfo.InvariantCulture;
        try
        {
            using (var session = new Session(arguments.Length > 0 ? arguments[0] : "127.0.0.1:47800")) Play(session);
            return 0;
        }
        catch (HapticdException error)
        {
            Console.Error.WriteLine("Press: " + error.Message);
            return 1;
        }
    }
}
