#!/usr/bin/python3
"""pluck.py in asyncio: one task drags the finger over the string, another prints what happens as it comes. Start the daemon first:

    hapticd --clock virtual --device scripted --scene single_string

usage: pluck_async.py [HOST:PORT]"""
import asyncio
import sys

import hapticd
from pluck import path


async def tell(session):
    """Prints events until it is cancelled."""
    async for event in session.events():
        if event.kind == "tone":
            print(f"a tone of {event.body.frequency_hz:.1f} Hz")
        elif event.kind == "contact":
            print("touched" if event.body.phase == 1 else "let go")


async def main():
    async with hapticd.AsyncSession(sys.argv[1] if len(sys.argv) > 1 else "127.0.0.1:47800") as session:
        await session.acquire("pluck_async.py")
        await session.load_scene("single_string")
        await session.subscribe(divisor=1, sections=["TOOLS"])
        telling = asyncio.create_task(tell(session))
        result = await session.run(poses=list(path()))
        await session.ping()  # what the run told has been printed before the answer
        telling.cancel()
        print(f"{result.steps} ticks, {len(result.states)} States, {len(result.events)} events")


if __name__ == "__main__":
    asyncio.run(main())
