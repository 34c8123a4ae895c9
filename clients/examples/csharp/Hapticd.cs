// libhapticd-client for C#: its C functions, and a class around them that raises HapticdException. In Unity put this file into Assets,
// and call Poll() in Update(). The meaning of every function and member is in hapticd_client.h.
using System;
using System.Runtime.InteropServices;
using System.Text;

namespace Hapticd
{
    public enum EventKind { Tone = 1, Contact = 2, StringRadius = 3, Fault = 4, Scene = 5, Lease = 6 }
    public enum Order { Engage = 1, Disengage = 2, Stop = 3, Clear = 4 }

    [StructLayout(LayoutKind.Sequential)]
    public struct Pose
    {
        [MarshalAs(UnmanagedType.ByValArray, SizeConst = 3)] public double[] Position;  // m
        [MarshalAs(UnmanagedType.ByValArray, SizeConst = 4)] public double[] Quaternion;  // w x y z
    }

    [StructLayout(LayoutKind.Sequential)]
    public struct RunResult
    {
        public uint Size, MissingStates;
        public ulong Steps, NextTick, HeldInputs;
        [MarshalAs(UnmanagedType.ByValArray, SizeConst = 32)] public byte[] StateHash;
    }

    [StructLayout(LayoutKind.Sequential)]
    public struct Tool
    {
        public int ToolId;  // -1: not told
        public uint Flags;
        [MarshalAs(UnmanagedType.ByValArray, SizeConst = 3)] public double[] HandPosition;  // m
        [MarshalAs(UnmanagedType.ByValArray, SizeConst = 3)] public double[] ToolPosition;  // m
        [MarshalAs(UnmanagedType.ByValArray, SizeConst = 4)] public float[] HandQuaternion;
        [MarshalAs(UnmanagedType.ByValArray, SizeConst = 4)] public float[] ToolQuaternion;
        [MarshalAs(UnmanagedType.ByValArray, SizeConst = 6)] public float[] Wrench;  // N and N m
        public float MinimumGap;  // m
        uint reserved;
    }

    [StructLayout(LayoutKind.Sequential)]
    public struct StringState
    {
        public int StringIndex;  // -1: not told
        public uint Phase;
        [MarshalAs(UnmanagedType.ByValArray, SizeConst = 3)] public float[] Deflection;  // m
        public float Lambda, Radius;
        uint reserved;
    }

    [StructLayout(LayoutKind.Sequential)]
    public struct State
    {
        public uint Size, SceneId;
        public ulong Tick, TimeNs;
        public int LoopState, Cause;
        public uint ToolCount, StringCount;
        [MarshalAs(UnmanagedType.ByValArray, SizeConst = 8)] public Tool[] Tools;
        [MarshalAs(UnmanagedType.ByValArray, SizeConst = 32)] public StringState[] Strings;
    }

    [StructLayout(LayoutKind.Sequential)]
    public struct Event
    {
        public uint Size;
        public EventKind Kind;
        public ulong TimeNs;
        public long OwnNs;
        public ulong Dropped;
        public int ToolId;
        public uint PartIndex;
        public int StringIndex, BodyIndex, LineIndex, Phase, Cause, Latched;
        public float Frequency, Amplitude, Level, Lambda, Decay, Delta, Force, NormalSpeed, TangentialSpeed;
        [MarshalAs(UnmanagedType.ByValArray, SizeConst = 3)] public float[] Point;
        [MarshalAs(UnmanagedType.ByValArray, SizeConst = 3)] public float[] Normal;
        [MarshalAs(UnmanagedType.ByValArray, SizeConst = 257)] public byte[] Message;
        [MarshalAs(UnmanagedType.ByValArray, SizeConst = 3)] byte[] reserved;
    }

    public class HapticdException : Exception
    {
        public readonly int Code;
        public HapticdException(int code, string message) : base(message) { Code = code; }
    }

    static class Native
    {
        const string Library = "libhapticd-client.so.0";

        [StructLayout(LayoutKind.Sequential)]
        public struct Options
        {
            public uint Size, TimeoutMs;
            public IntPtr Server, KeyFile;
        }

        [DllImport(Library)] public static extern IntPtr hapticd_version();
        [DllImport(Library)] public static extern int hapticd_open(ref Options options, out IntPtr session);
        [DllImport(Library)] public static extern void hapticd_close(IntPtr session);
        [DllImport(Library)] public static extern IntPtr hapticd_last_error(IntPtr session);
        [DllImport(Library)] public static extern int hapticd_poll(IntPtr session, uint waitMs);
        [DllImport(Library)] public static extern int hapticd_acquire(IntPtr session, byte[] holder);
        [DllImport(Library)] public static extern int hapticd_load_scene(IntPtr session, byte[] scene);
        [DllImport(Library)] public static extern int hapticd_set(IntPtr session, byte[] path, double[] values, UIntPtr count);
        [DllImport(Library)] public static extern int hapticd_get(IntPtr session, byte[] path, [Out] double[] values, UIntPtr capacity, out UIntPtr count);
        [DllImport(Library)] public static extern int hapticd_subscribe(IntPtr session, uint divisor);
        [DllImport(Library)] public static extern int hapticd_run(IntPtr session, ulong steps, double[] poses, UIntPtr count, ref RunResult result);
        [DllImport(Library)] public static extern int hapticd_next_state(IntPtr session, ref State state);
        [DllImport(Library)] public static extern int hapticd_next_event(IntPtr session, ref Event found);
        [DllImport(Library)] public static extern int hapticd_play_gesture(IntPtr session, byte[] gesture, uint repeat);
        [DllImport(Library)] public static extern int hapticd_order(IntPtr session, int order);

        public static byte[] Text(string text) { return Encoding.UTF8.GetBytes(text + "\0"); }
    }

    /// A session with a daemon. One thread at a time; Dispose() ends it.
    public sealed class Session : IDisposable
    {
        IntPtr session;

        public Session(string server = "127.0.0.1:47800", uint timeoutMs = 5000)
        {
            GCHandle text = GCHandle.Alloc(Native.Text(server), GCHandleType.Pinned);
            try
            {
                var options = new Native.Options { Size = (uint)Marshal.SizeOf(typeof(Native.Options)), TimeoutMs = timeoutMs, Server = text.AddrOfPinnedObject() };
                Check(Native.hapticd_open(ref options, out session));
            }
            finally { text.Free(); }
        }

        ~Session() { Dispose(); }
        public void Dispose()
        {
            Native.hapticd_close(session);
            session = IntPtr.Zero;
            GC.SuppressFinalize(this);
        }

        public static string Version { get { return Marshal.PtrToStringAnsi(Native.hapticd_version()); } }
        public void Poll(uint waitMs = 0) { Check(Native.hapticd_poll(session, waitMs)); }
        public void Acquire(string holder) { Check(Native.hapticd_acquire(session, Native.Text(holder))); }
        public void LoadScene(string scene) { Check(Native.hapticd_load_scene(session, Native.Text(scene))); }
        public void Set(string path, params double[] values) { Check(Native.hapticd_set(session, Native.Text(path), values, (UIntPtr)values.Length)); }
        public void Subscribe(uint divisor) { Check(Native.hapticd_subscribe(session, divisor)); }
        public void PlayGesture(string gesture, uint repeat = 1) { Check(Native.hapticd_play_gesture(session, Native.Text(gesture), repeat)); }
        public void Give(Order order) { Check(Native.hapticd_order(session, (int)order)); }

        public double[] Get(string path)
        {
            var values = new double[1024];
            UIntPtr count;
            Check(Native.hapticd_get(session, Native.Text(path), values, (UIntPtr)values.Length, out count));
            Array.Resize(ref values, (int)count);
            return values;
        }

        public RunResult Run(ulong steps, params Pose[] poses)
        {
            var numbers = new double[poses.Length * 7];
            for (int k = 0; k < poses.Length; ++k)
            {
                poses[k].Position.CopyTo(numbers, 7 * k);
                poses[k].Quaternion.CopyTo(numbers, 7 * k + 3);
            }
            var result = new RunResult { Size = (uint)Marshal.SizeOf(typeof(RunResult)) };
            Check(Native.hapticd_run(session, steps, numbers, (UIntPtr)poses.Length, ref result));
            return result;
        }

        /// The oldest unread State; false when there is none.
        public bool NextState(ref State state)
        {
            state.Size = (uint)Marshal.SizeOf(typeof(State));
            return Check(Native.hapticd_next_state(session, ref state)) == 1;
        }

        /// The oldest unread event; false when there is none.
        public bool NextEvent(ref Event found)
        {
            found.Size = (uint)Marshal.SizeOf(typeof(Event));
            return Check(Native.hapticd_next_event(session, ref found)) == 1;
        }

        int Check(int code)
        {
            if (code < 0) throw new HapticdException(code, Marshal.PtrToStringAnsi(Native.hapticd_last_error(session)));
            return code;
        }
    }
}
